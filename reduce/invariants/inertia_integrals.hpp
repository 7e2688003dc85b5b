// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>

#include "reduce/linalg/dense/symmetric_matrix.hpp"

/// Inertia integrals of a body whose displacement is u(x) = sum_k phi_k(x) q_k.
///
/// For solids the consistent mass matrix is M = m (x) I_3 with the scalar m_ac = integral N_a N_c dm, and
/// nodal positions and shapes are interpolated by the same N (isoparametric elements).  So the integrals are
/// exact products with m; with x_a the vector of all nodes' coordinates a and Phi_a the rows of T for
/// direction a,
///
///     mass = 1^T m 1             S_x(a) = x_a^T m 1            S_xx(a, b) = x_a^T m x_b
///     S_phi(a, k) = 1^T m Phi_a,k                              S_xphi(3 a + b, k) = x_a^T m Phi_b,k
///     S_phiphi(a, b)(k, l) = Phi_a,k^T m Phi_b,l
///     M_se = S_phiphi(xx) + S_phiphi(yy) + S_phiphi(zz)
///
/// With lumped mass m is diagonal and the same products hold.  The standard input data (O. Wallrapp, Mech.
/// Struct. Mach. 22 (1994), 283) follow: mdCM = S_x, Ct = S_phi^T, Cr from the antisymmetric part of S_xphi,
/// Me = M_se, J from S_xx, S_xphi and S_phiphi, Gr, Ge, Oe from S_xphi and S_phiphi.
namespace flexura::reduce {

/// The same members as superelement::InertiaIntegrals, in the same order and units.
struct InertiaIntegrals {
  double mass = 0.0;                               ///< [kg]
  Eigen::Vector3d S_x = Eigen::Vector3d::Zero();   ///< [kg m], about Bo
  Eigen::Matrix3d S_xx = Eigen::Matrix3d::Zero();  ///< [kg m^2], about Bo
  Eigen::Matrix3Xd S_phi;                          ///< 3 x n
  Eigen::MatrixXd S_xphi;                          ///< 9 x n, row 3 a + b
  std::array<Eigen::MatrixXd, 6> S_phiphi;         ///< xx, yy, zz, xy, yz, zx; each n x n
};

/// Computes all of them.  `points` n_nodes x 3 [m]; `T` 3 n_nodes x n, row 3 node + direction; `m` n_nodes x
/// n_nodes.
InertiaIntegrals inertia_integrals(const linalg::SymmetricMatrix& m,
                                   const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>& points,
                                   const Eigen::MatrixXd& T);

}  // namespace flexura::reduce
