// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "reduce/cms/errors/error_estimate.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"

/// How many fixed-interface modes: by number, by frequency, by effective mass, or by accuracy.
///
/// By accuracy: the body's own frequencies in the band [0, omega] and the interface's dynamic stiffness there
/// shall be right to a given fraction, as the safe estimates of error_estimate.hpp have it.  The estimate of
/// the first k modes needs nothing but the constraint modes' inertia loads Mhat = M_ib + M_ii Psi:
///
///     Mhat^T F_rs Mhat = Mhat^T K_ii^-1 Mhat - sum_j<=k p_j p_j^T / omega_j^2,    p_j = Mhat^T phi_j,
///
/// so all k are tried with one solve; the next order, with omega_j^4, likewise.
///
/// By effective mass: the modes, from below, whose (p_j^T R_b)^2 add up to the wanted fraction of the
/// interior's mass and moments of inertia for each of the six rigid motions.
namespace flexura::reduce {

/// The fixed-interface problem, seen from the interface.
struct InteriorDynamics {
  Eigen::MatrixXd K_bb, M_bb;     ///< condensed: of the constraint modes alone
  Eigen::MatrixXd compliance;     ///< Mhat^T K_ii^-1 Mhat, n_b x n_b
  Eigen::MatrixXd growth;         ///< Mhat^T K_ii^-1 M_ii K_ii^-1 Mhat, n_b x n_b
  Eigen::MatrixXd participation;  ///< rows p_j^T, n_q x n_b
  Eigen::VectorXd omega2;         ///< n_q
  double omega2_next = 0.0;
};

/// What modes with these participations (rows) and eigenvalues leave of compliance and growth.
struct DroppedModes {
  Eigen::MatrixXd share, growth;
};
DroppedModes dropped_modes(const InteriorDynamics& interior, const Eigen::MatrixXd& participation,
                           const Eigen::VectorXd& omega2);

/// The reduction with the first `count` modes: matrices and estimate only.
Reduction with_first_modes(const InteriorDynamics& interior, int count);

/// Safe estimates of relative errors in the band [0, omega].
struct BandError {
  double frequency = 0.0;  ///< greatest of the free body's frequencies; modes of a cluster share the sum
  double interface = 0.0;  ///< of the interface's dynamic stiffness (interface_error)
  double worst() const { return std::max(frequency, interface); }
};
BandError band_error(const Reduction& reduction, double omega);

/// The fewest modes, clusters whole, that reach the accuracy; none where all of them do not.
std::optional<int> modes_for_accuracy(const InteriorDynamics& interior, double omega, double accuracy);

/// The fewest modes, clusters whole, whose effective mass is the wanted fraction of the interior's own
/// (`interior_mass`, 6 x 6, of the rigid motions `R_b`, n_b x 6, about the mass centre).
std::optional<int> modes_for_effective_mass(const InteriorDynamics& interior, const Eigen::MatrixXd& R_b,
                                            const Eigen::MatrixXd& interior_mass, double fraction);

}  // namespace flexura::reduce
