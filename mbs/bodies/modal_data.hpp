// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mbs/base/math/spatial.hpp"
#include "mbs/superelement/superelement.hpp"

/// What a body in modal coordinates is made of; modal_basis.hpp makes it from a superelement.
namespace flexura::mbs {

/// A point of the body that markers can sit on: u = Phi_t s, rotation exp(Phi_r s).
struct FlexibleNode {
  std::string name;
  Vector3d p_BoN_B = Vector3d::Zero();
  Eigen::Matrix3Xd Phi_t, Phi_r;  ///< 3 x m
  /// -K0F of the node's u_x .. theta_z, six blocks of m x m below one another; empty without stiffening and
  /// where all vanish.
  Eigen::MatrixXd second = {};
};

/// How much of the inertia coupling between deformation and large motion is kept.
enum class Coupling {
  constant,  ///< mass matrix of the undeformed body but for the shift of its centre; no centrifugal loads
  partial,   ///< to first order in s in the mass matrix: without the integrals of Phi_a Phi_b beside M_e
  full       ///< all integrals
};

/// The integrals of the second-order displacement, see modal_body.hpp.
struct SecondOrderIntegrals {
  Eigen::MatrixXd t;  ///< 3 m x m: K0t_a
  Eigen::MatrixXd x;  ///< 9 m x m, block 3 a + b: N_ab
};

/// The body's integrals and stiffness in the modal coordinates s.
struct ModalData {
  superelement::InertiaIntegrals inertia;  ///< with the columns of the basis in place of the shapes
  Eigen::VectorXd stiffness;               ///< m: omega_i^2 for mass-normalised modes
  Eigen::VectorXd damping;                 ///< m: the diagonal of D_e
  Eigen::MatrixXd damping_coupling = {};   ///< m x m: D_e beside its diagonal; empty: D_e is diagonal
  /// m x m: C^-T diag(zeta_k omega_k^2) C^-1 of the ratios zeta_k that are asked of eigenmodes s = C c; empty where D_e is made of
  /// D_se.
  Eigen::MatrixXd asked_damping = {};
  std::vector<FlexibleNode> nodes;
  Eigen::MatrixXd Y;  ///< n_se x m, u_se = Y s
  Eigen::MatrixXd frame =
      {};  ///< n_se x k: directions that do not move in B, frame^T Y = 0; empty: mean axes
  Coupling coupling = Coupling::full;
  std::optional<SecondOrderIntegrals> second = {};  ///< with geometric stiffening, which needs full coupling

  /// D_e, m x m: the generalised forces -D_e s'.
  Eigen::MatrixXd damping_matrix() const {
    Eigen::MatrixXd D = damping.asDiagonal();
    if (damping_coupling.size() > 0) D += damping_coupling;
    return D;
  }
};

}  // namespace flexura::mbs
