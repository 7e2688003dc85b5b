// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "mbs/solver/position/assemble.hpp"

/// A mechanism that stands assembled at its start time, ready for any solver.
namespace flexura::mbs {

struct StartedMechanism {
  SolverOptions options;
  std::unique_ptr<Mechanism> mechanism;  ///< without its redundant rows
  std::vector<RedundantRow> redundant;
  AssembleReport assembly;
  State state;
  Eigen::VectorXd v_dot;
  std::vector<std::string> notes;  ///< of redundancy and assembly, for the user
};

/// True where the mechanism's bodies deform: Radau IIA is then the method to take where none is named.
bool has_deformation(const Mechanism& mechanism);

/// What was given of the state at the start: entries of p and v that the assembly should rather not move.
struct GivenState {
  std::vector<bool> positions, velocities;
  bool whole = false;  ///< states of an earlier run, with deformation and contacts
};

/// Assembles `out.mechanism` from the guess `out.state` at the time it holds, on all levels, and drops redundant
/// constraint rows; `out.notes` gets what the user should know.  Throws OpenLoops where loops do not close, AssemblyError.
void assemble_start(StartedMechanism& out, const GivenState& given);

/// Takes the note back that bodies ring from the start: for a state that is moved into equilibrium.
void forget_ringing(std::vector<std::string>& notes);

}  // namespace flexura::mbs
