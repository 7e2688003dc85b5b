// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "reduce/assembly/input/initial_strain.hpp"
#include "reduce/assembly/tied_solver.hpp"

/// Geometric stiffening: the stiffness that a stressed body has beyond its elastic one,
///
///     K_G = integral (grad N_a . sigma grad N_b) dV (x) I_3,     K_0 = T^T K_G T,
///
/// for the stress sigma of unit loads: inertia forces of unit acceleration of the frame B (K0t), of unit
/// angular acceleration (K0r), of unit products omega_a omega_b (K0omega), and unit loads on the interface
/// dofs (K0F). O. Wallrapp, R. Schwertassek, Int. J. Numer. Meth. Eng. 32 (1991), 1833.
///
/// A single one of these loads is not in equilibrium.  Each is balanced by reactions at six interface dofs
/// that hold the body in a statically determinate way (`held`); the loads that act together on a moving body
/// are in equilibrium (d'Alembert), so that these reactions cancel in the sum, whatever six were chosen.  K0F
/// of the held dofs is zero. Stresses of the elastic vibration's own inertia forces are not part of it.
///
/// Load cases are such loads, too (K0p).  Those of a preload hold each other in balance: its stress is D (strain - initial
/// strain) of the free body, and what joints that hold the body against it add comes by their forces, K0F.
///
/// Loads keep their direction.  Forces that follow the body add their own load stiffness.
namespace flexura::reduce {

/// Members as in superelement::StiffeningTerms; each matrix n x n.
struct StiffeningTerms {
  std::array<Eigen::MatrixXd, 3> K0t;  ///< per m/s^2 along x, y, z
  std::array<Eigen::MatrixXd, 3> K0r;  ///< per rad/s^2 about x, y, z, at Bo
  std::array<Eigen::MatrixXd, 6>
      K0omega;                       ///< per rad^2/s^2: xx, yy, zz, xy, yz, zx (omega_x omega_y counted once)
  std::vector<Eigen::MatrixXd> K0F;  ///< per N or N m on each boundary dof
  std::vector<Eigen::MatrixXd> K0p;  ///< of each further load
  std::vector<int> held;             ///< the boundary dofs that balance
};

/// A load beside those of motion and interfaces.
struct StressingLoad {
  Eigen::VectorXd forces;  ///< 3 n_nodes [N]
  CellStrains strain;      ///< of a preload, or empty
};

/// Computes all terms.  `Psi` (n_i x n_b) and `K_bb` (condensed, n_b x n_b) are the constraint modes and the
/// static stiffness of the interface, `T` (3 n_nodes x n) the shapes on all nodes.
StiffeningTerms stiffening_terms(const Part& part, const TiedSolver& solver, const Eigen::MatrixXd& Psi,
                                 const Eigen::MatrixXd& K_bb, const Eigen::MatrixXd& T,
                                 const std::vector<StressingLoad>& more = {},
                                 const linalg::Progress& progress = {});

}  // namespace flexura::reduce
