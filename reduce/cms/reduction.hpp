// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "reduce/assembly/part.hpp"
#include "reduce/invariants/inertia_integrals.hpp"
#include "reduce/linalg/progress.hpp"
#include "reduce/recovery/stiffening.hpp"

/// The result of a reduction: what a superelement file holds, in plain C++ and Eigen.
namespace flexura::reduce {

struct ReducedInterface {
  std::string name;
  Tie tie = Tie::rigid;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< p_BoN_B [m]
  std::vector<int> directions;                      ///< 0-2 displacement, 3-5 rotation
  int first_dof = 0;
};

/// What the reduction did and how well, for reports.
struct ReductionReport {
  int n_nodes = 0, n_cells = 0;
  int n_i = 0, n_b = 0, n_q = 0;
  double seconds_assembly = 0.0;
  double seconds_ordering = 0.0, seconds_symbolic = 0.0, seconds_factor = 0.0;
  double seconds_constraint_modes = 0.0, seconds_normal_modes = 0.0, seconds_projection = 0.0;
  double seconds_estimate = 0.0, seconds_stiffening = 0.0, seconds_stress = 0.0;
  double factor_nonzeros = 0.0, factor_flops = 0.0;
  double smallest_pivot = 0.0;       ///< of the factor, relative to the diagonal
  double peak_memory_bytes = 0.0;    ///< of the process so far
  int solved_right_hand_sides = 0;   ///< by the eigensolver
  double rigid_strain = 0.0;         ///< |K_se R| over |K_bb| |R|: zero to round-off
  double constraint_residual = 0.0;  ///< ||K_ii Psi + K_ib|| / ||K_ib||, averages included
  Eigen::VectorXd mode_residual;     ///< n_q: ||K phi - omega^2 M phi|| / ||K phi||
};

struct Reduction {
  std::vector<ReducedInterface> interfaces;
  int n_b = 0;                 ///< boundary dofs: columns 0 ... n_b - 1
  int n_q = 0;                 ///< modes: columns n_b ...
  Eigen::MatrixXd K_se, M_se;  ///< n x n
  Eigen::VectorXd omega2;      ///< n_q [rad^2/s^2]
  InertiaIntegrals inertia;
  std::optional<StiffeningTerms> stiffening;  ///< if asked for
  /// 6 n_s x n at the options' stress nodes, if asked for (recovery/stress.hpp).
  Eigen::MatrixXd stress_modes;
  Eigen::MatrixXf
      shapes;  ///< 3 n_v x n at the nodes asked for: rows x, y, z of the first, then the second, ...
  /// n_b x n_b: Mhat^T F_rs Mhat, the dropped modes' share of the interface's dynamics (error_estimate.hpp)
  /// [kg s^2].
  Eigen::MatrixXd dropped;
  double omega2_dropped = 0.0;  ///< the first dropped eigenvalue [rad^2/s^2]
  ReductionReport report;

  int n() const { return n_b + n_q; }
};

}  // namespace flexura::reduce
