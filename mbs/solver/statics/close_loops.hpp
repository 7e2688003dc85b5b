// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/position/openings.hpp"

/// Loops of mechanisms whose bodies deform.  Joints turn; bodies are not bent to fit:
///
/// 1. With every deformation held the other coordinates close the loops, prescribed ones last
///    (assemble_positions()).
/// 2. What no motion of joints closes (a bar too long for its bearings, pins that are not parallel) is closed
///    by deformation, from where the joints left the least open, and by the least of it:
///
///        min U(p)  subject to  g(p) = 0,      U the strain energy of modal bodies, beams and their segments,
///
///    the equilibrium of the mechanism without any other load.
namespace flexura::mbs {

/// The loops do not close.
class OpenLoops : public AssemblyError {
 public:
  OpenLoops(const std::string& what, Eigen::VectorXd p_nearest, Eigen::VectorXd g_left)
      : AssemblyError(what), p(std::move(p_nearest)), g(std::move(g_left)) {}
  Eigen::VectorXd p, g;  ///< where they are open the least of all that was tried, and what is left (n_lambda)
};

/// The velocity coordinates (n_v) all of whose positions, with those that go with them, are marked (n_p).
std::vector<bool> velocities_of(const Mechanism& mechanism, const State& s, const std::vector<bool>& marked);

/// What the second step did.
struct StrainedLoops {
  State undeformed;                ///< where the first one ended
  std::vector<Opening> openings;   ///< of the loops there
  bool are_parts_as_made = false;  ///< open by less than parts are made to, a millionth of the positions
  bool is_least = true;  ///< false: that energy was not found, and the deformation is the smallest by mass
  Eigen::MatrixXd stiffness;  ///< of the deformations (n_d x n_d, those marked), at `undeformed`
  double energy = 0.0;        ///< U [J]
};

/// The velocity coordinates by which bodies deform: modal ones and those between the segments of beams.
std::vector<bool> deformations_of(const Mechanism& mechanism, const State& s);

/// Moves s.p.  Empty where no body was deformed to close the loops.  Throws OpenLoops.
std::optional<StrainedLoops> close_loops(const Mechanism& mechanism, State& s, const AssembleOptions& keep,
                                         AssembleReport& report);

/// The strain energy that the loads at the start ask for: with r what they and the inertia of the motion
/// leave unbalanced in the deformations, K their stiffness, r^T K^-1 r / 2.  Of the mechanism without its
/// redundant rows, moving as `moving` does.
double energy_of_loads(const Mechanism& mechanism, const StrainedLoops& strained,
                       const std::vector<bool>& deforms, const State& moving);

/// One sentence: by how much what was open, and what closing it stored.
std::string sentence_of(const StrainedLoops& strained, const Mechanism& mechanism, const State& s);

}  // namespace flexura::mbs
