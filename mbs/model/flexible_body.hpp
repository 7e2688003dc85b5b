// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "mbs/math/spatial.hpp"
#include "mbs/superelement/superelement.hpp"

/// A flexible body in its floating frame B (theory: Schwertassek and Wallrapp; Shabana).
///
/// A particle stands at rho = x + Phi(x) s in B: x where it is undeformed, s the m modal coordinates.
/// Everything follows from the integrals over the undeformed body of products of x and Phi, brought from the
/// superelement to the chosen basis (u_se = Y s).  With, for a, b in x, y, z,
///
///     d = int rho dm                     B_ab,i(s) = int rho_a Phi_i,b dm = int x_a Phi_i,b + s_j Phi_j,a
///     Phi_i,b dm J(s) = int |rho|^2 1 - rho rho^T dm
///     P_ab = int rho_a (Phi s')_b dm = B_ab,i s'_i,          Q_ab = int rho_a (Phi s'')_b dm = B_ab,i s''_i
///
/// the virtual work of the inertia forces gives (a, alpha: acceleration of Bo and angular acceleration, in B)
///
///     force    = m a + alpha x d + w x (w x d) + 2 w x (C_t s') + C_t s''
///     torque   = d x a + J alpha + w x J w + 2 (w tr P - P^T w) + vec(Q - Q^T)
///     modal_i  = C_t,i . a + alpha . int rho x Phi_i + w.B_i w - |w|^2 tr B_i + 2 w . int (Phi s') x Phi_i
///                + (M_e s'')_i + omega_i^2 s_i + d_i s'_i
///
/// complete in s (second-order terms of J are kept), at a cost of O(m^2) that does not depend on the mesh.
/// Gravity enters as a - g in place of a.
namespace flexura::mbs {

/// A point of the body that markers can sit on: u = Phi_t s, rotation exp(Phi_r s).
struct FlexibleNode {
  std::string name;
  Vector3d p_BoN_B = Vector3d::Zero();
  Eigen::Matrix3Xd Phi_t, Phi_r;  ///< 3 x m
};

/// The body's integrals and stiffness in the modal coordinates s.
struct ModalData {
  superelement::InertiaIntegrals inertia;  ///< with the columns of the basis in place of the shapes
  Eigen::VectorXd stiffness;               ///< m: omega_i^2 for mass-normalised modes
  Eigen::VectorXd damping;                 ///< m: 2 zeta omega_i
  std::vector<FlexibleNode> nodes;
  Eigen::MatrixXd Y;  ///< n_se x m, u_se = Y s
};

class FlexibleBody {
 public:
  /// What an evaluation leaves for the next: one of each body in the scratch of a mechanism.
  struct Work {
    Eigen::VectorXd B;    ///< 9 m, block 3 a + b
    Eigen::VectorXd T_s;  ///< 9 m
    Eigen::VectorXd W;    ///< 3 m: int (Phi s') x Phi_i dm
    Vector3d d = Vector3d::Zero();
    Matrix3d J = Matrix3d::Zero();
    Eigen::Matrix3Xd C_r;  ///< 3 x m: int rho x Phi_i dm, expressed in B
  };

  /// Throws std::invalid_argument when the sizes of the data disagree.
  explicit FlexibleBody(ModalData data);

  int m() const { return m_; }
  const ModalData& data() const { return data_; }
  double mass() const { return data_.inertia.mass; }
  int find_node(const std::string& name) const;  ///< -1 when there is none
  Work make_work() const;

  /// B, d, J and C_r of `work` at s.
  void set_position(const double* s, Work& work) const;

  /// The mass blocks that do not depend on s: C_t (3 x m) and M_e (m x m).
  const Eigen::Matrix3Xd& C_t() const { return data_.inertia.S_phi; }
  const Eigen::MatrixXd& M_e() const { return M_e_; }

  /// After set_position: wrench (about Bo) and modal forces that the motion needs, all in B, elastic and
  /// damping forces included.  V = (w_WB, anything), A = (alpha, a of Bo - g).
  Spatial inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                           const Spatial& A, Work& work, double* modal) const;

  /// After set_position; V = (w_WB, v_WBo) in B.
  double kinetic_energy(const double* s_dot, const Spatial& V, const Work& work) const;
  double strain_energy(const double* s) const;
  double dissipated_power(const double* s_dot) const;

  /// Largest displacement of a node, or 1/sqrt(mass), for unit s_i: its inverse is the size of s_i.
  double amplitude(int i) const;

 private:
  int m_;
  ModalData data_;
  Eigen::MatrixXd M_e_;
  /// Rows 3 a + b of blocks T_ab with B_ab = int x_a Phi_,b + T_ab s: 9 m x m.
  Eigen::MatrixXd T_;
  /// Rows c of blocks T_ab - T_ba, (a, b, c) cyclic: 3 m x m.
  Eigen::MatrixXd T_skew_;
  Eigen::VectorXd B_0_;  ///< 9 m
};

}  // namespace flexura::mbs
