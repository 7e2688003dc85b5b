// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/estimate/mesh_error.hpp"
#include "reduce/recovery/peak_stress.hpp"

/// What the mesh costs in accuracy, by frequency and by interface, from the energies it leaves
/// (reduce/estimate/enriched_error.hpp, mesh_error.hpp).
///
/// A mesh makes the part too stiff.  With x the share of the energy that is error,
///
///     frequency:   f_h / f - 1 = (1 - x)^(-1/2) - 1,    of a mode of the free body,
///     compliance:  1 - C_h / C = x,                     of a direction of an interface while all others are held.
///
/// Exact for a single shape; x from 1 on says no more than that the mesh does not resolve it.
namespace flexura::reduce {

struct Reduction;

/// And of the stresses of the elements themselves, root mean square over the part in the measure of energy: x^(1/2).
struct MeshShare {
  struct Stress {
    double mean = 0.0;     ///< relative
    PeakStress peak = {};  ///< of the greatest nodal stress; not known without stress modes
  };
  struct Mode {
    double omega2;  ///< of the reduced free body [rad^2/s^2]
    double error;   ///< relative, of the frequency; infinite where the mesh does not resolve it
    Stress stress = {};
  };
  struct Interface {
    std::string name;
    double
        error;  ///< relative, of the static compliance in the worst direction; infinite likewise; -1: not known, as
                ///< it or another is concentrated (is_concentrated)
    Stress stress = {};  ///< under its unit loads: the worst mean and the worst peak
  };
  std::vector<Mode> modes;            ///< the lowest elastic ones, ascending
  std::vector<Interface> interfaces;  ///< where there are two or more
  /// n_cells x n_states: of each cell in the order of the blocks, its share of x, modes first, then the directions of
  /// the interfaces.
  Eigen::MatrixXf by_cell;
  bool rough = false;  ///< by recovered stresses, which where few cells lie across are off by up to five
};

/// The motions of the superelement that are judged.
struct JudgedMotions {
  JudgedStates states;
  Eigen::VectorXd energy;          ///< y^T K_se y
  int n_modes = 0;                 ///< the first ones; after them the static answers, interface by interface
  std::vector<std::string> names;  ///< of those interfaces
  std::vector<int> n_directions;   ///< 0: as the first
  /// The first of an interface's states, and how many.
  std::pair<Eigen::Index, Eigen::Index> states_of(std::size_t interface) const;
};

/// The elastic modes up to `omega_max` [rad/s], at least the first 10 and at most 60, and the answers to unit loads in
/// each direction of each interface while all others are held.
JudgedMotions judged_motions(const Reduction& reduction, double omega_max);

MeshShare mesh_share(const JudgedMotions& motions, const MeshEnergy& left);

/// Takes out the compliance of interfaces that load, or are held by, a point or a line of elastic solids, where it has no limit.
void leave_out_concentrated(const Part& part, const JudgedMotions& motions, MeshShare& share);

/// Puts in what is known of the greatest stresses of the judged motions.
void add_peaks(const JudgedMotions& motions, const std::vector<PeakStress>& peaks, MeshShare& share);

}  // namespace flexura::reduce
