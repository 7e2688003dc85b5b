// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/cms/result/mesh_share.hpp"
#include "reduce/invariants/inertia_integrals.hpp"
#include "reduce/linalg/dense/factor_figures.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/recovery/node_motions.hpp"
#include "reduce/recovery/stiffening.hpp"

/// The result of a reduction: what a superelement file holds, in plain C++ and Eigen.
namespace flexura::reduce {

/// [Hz] of an eigenvalue [rad^2/s^2]; 0 for what round-off made negative.
inline double frequency_hz(double omega2) {
  return std::sqrt(std::max(omega2, 0.0)) / (2.0 * std::numbers::pi);
}

struct ReducedInterface {
  std::string name;
  Tie tie = Tie::rigid;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< p_BoN_B [m]
  std::vector<int> directions;                      ///< 0-2 displacement, 3-5 rotation
  int first_dof = 0;
  std::vector<int> following =
      {};  ///< directions that are no dofs: (u, theta)(following[k]) = follow.row(k) u_se
  Eigen::MatrixXd follow = {};
  std::vector<int> free =
      {};  ///< directions that it does not keep: (u, theta)(free[k]) = free_motion.row(k) u_se
  Eigen::MatrixXd free_motion = {};
};

/// A load case on the shapes.
struct ReducedLoad {
  std::string name;
  Eigen::VectorXd p_se;     ///< n, T^T p
  Eigen::Matrix3Xd moment;  ///< 3 x n, sum of phi_k x p
  bool is_preload = false;
};

/// What the section forces of Part::bars are made of (reduce/library/bar_sections.hpp).
struct BarMotions {
  Eigen::MatrixXd nodes;   ///< 12 n_bars x n: (u, theta) of both nodes by the shapes
  Eigen::MatrixXd points;  ///< 3 n_points x n: displacements of their masses, bar by bar
  /// 12 n_bars x (6 + n_b + loads): what the shapes lack of the answers to the fields of StressModes::of_acceleration, and to the
  /// load cases; empty: not known.
  Eigen::MatrixXd lacks;
};

/// What the reduction did and how well, for reports.
struct ReductionReport {
  int n_nodes = 0, n_cells = 0;
  int n_i = 0, n_b = 0, n_q = 0;
  double seconds_assembly = 0.0;
  linalg::FactorFigures factor;
  double seconds_constraint_modes = 0.0, seconds_normal_modes = 0.0, seconds_projection = 0.0;
  double seconds_estimate = 0.0, seconds_mesh_error = 0.0, seconds_stiffening = 0.0, seconds_stress = 0.0;
  double processor_seconds_mesh_error = 0.0;  ///< all cores together
  double peak_memory_bytes = 0.0;             ///< of the process so far
  double peak_memory_of_others_bytes = 0.0;   ///< the greatest of a team's other processes; 0: there are none
  int solved_right_hand_sides = 0;            ///< by the eigensolver
  double rigid_strain = 0.0;  ///< |K_bb R| over |K_bb| |R| before rigid motions are taken out: round-off
  double rigid_error = 0.0;   ///< of rigid motions in the constraint modes before they are made exact
  double constraint_residual = 0.0;  ///< ||K_ii Psi + K_ib|| / ||K_ib||, averages included
  Eigen::VectorXd mode_residual;     ///< n_q: ||K phi - omega^2 M phi|| / ||K phi||
  /// n_q: what round-off leaves of it (linalg::EigenPairs); empty: not known
  Eigen::VectorXd mode_round_off;
  int certified_modes = -1;       ///< counted below the cut-off by Sylvester's law; -1: not counted
  double certified_omega2 = 0.0;  ///< the cut-off [rad^2/s^2]
  double seconds_certificate = 0.0;
  double band_frequency_error = -1.0, band_interface_error = -1.0;  ///< in the band asked for; -1: none
  int n_extra = 0;                          ///< response and load shapes among the modes
  int n_interface_modes = 0;                ///< of elastic ties, among the modes
  double interface_stiffness_error = -1.0;  ///< what they leave of it (interface_modes.hpp); -1: not known
  double seconds_interface_modes = 0.0;
  std::vector<std::string> notes;  ///< what was dropped, struck out, chosen
};

struct Reduction {
  std::vector<ReducedInterface> interfaces;
  int n_b = 0;                 ///< boundary dofs: columns 0 ... n_b - 1
  int n_q = 0;                 ///< modes: columns n_b ...
  Eigen::MatrixXd K_se, M_se;  ///< n x n
  Eigen::VectorXd omega2;      ///< n_q [rad^2/s^2]
  Eigen::MatrixXd D_se;        ///< n x n of dampers and the damping asked for, or empty
  InertiaIntegrals inertia;
  std::vector<ReducedLoad> loads;
  std::optional<StiffeningTerms> stiffening;  ///< if asked for
  /// 6 n_s x n at the options' stress nodes, if asked for (recovery/stress.hpp).
  Eigen::MatrixXd stress_modes;
  Eigen::MatrixXd stress_of_loads;  ///< 6 n_s x loads there, what each adds to the shapes'; empty: none
  Eigen::MatrixXd
      stress_of_acceleration;  ///< 6 n_s x (6 + n_b) there, as StressModes has it; empty: not known
  Eigen::MatrixXf
      shapes;  ///< 3 n_v x n at the nodes asked for: rows x, y, z of the first, then the second, ...
  std::optional<NodeMotions> nodes;  ///< if asked for: motions of all nodes
  std::optional<BarMotions> bars;    ///< of parts with bars, but not of a team
  /// n_b x n_b: Mhat^T F_rs Mhat, the dropped modes' share of the interface's dynamics (error_estimate.hpp)
  /// [kg s^2].
  Eigen::MatrixXd dropped;
  /// n_b x n_b: Mhat^T F_rs M_ii F_rs Mhat, how that share grows with omega^2 [kg s^4]; empty: not known.
  Eigen::MatrixXd dropped_growth;
  double omega2_dropped = 0.0;    ///< the first dropped eigenvalue [rad^2/s^2]
  std::optional<MeshShare> mesh;  ///< what the mesh costs in accuracy; none: not known
  ReductionReport report;

  int n() const { return n_b + n_q; }
};

/// Eigenvalues (ascending) of a body above which they are elastic: its rigid motions, six at most, stand out by ten
/// powers of ten, while elastic ones of one body do not spread that far from the largest static one.
inline double least_elastic(const Eigen::VectorXd& eigenvalues) {
  const Eigen::Index n = eigenvalues.size();
  return n > 0 ? 1e-9 * eigenvalues(std::min(n - 1, std::max<Eigen::Index>(n / 2, 6))) : 0.0;
}

}  // namespace flexura::reduce
