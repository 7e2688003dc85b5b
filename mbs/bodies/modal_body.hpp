// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "mbs/bodies/flexible_body.hpp"
#include "mbs/bodies/modal_basis.hpp"
#include "mbs/bodies/modal_data.hpp"

/// A body in modal coordinates in its floating frame B (theory: Schwertassek and Wallrapp; Shabana).
///
/// A particle stands at rho = x + Phi(x) s in B: x where it is undeformed, s the m modal coordinates.
/// Everything follows from the integrals over the undeformed body of products of x and Phi, brought from the
/// superelement to the chosen basis (u_se = Y s).  With, for a, b in x, y, z,
///
///     d         = int rho dm,   J(s) = int |rho|^2 1 - rho rho^T dm
///     B_ab,i(s) = int rho_a Phi_i,b dm = int x_a Phi_i,b + s_j Phi_j,a Phi_i,b dm
///     P_ab      = int rho_a (Phi s')_b dm = B_ab,i s'_i,   Q_ab = int rho_a (Phi s'')_b dm = B_ab,i s''_i
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
///
/// Geometric stiffening is the second-order displacement that deformation brings with it: a rod that bends
/// gets shorter between its ends.  With rho = x + Phi s + u2, u2 quadratic in s,
///
///     int u2_a dm = s^T K0t_a s / 2,   int x_a u2_b dm = s^T N_ab s / 2,
///     u2 at interface dof k = -s^T K0F_k s / 2
///
/// (what the work of a unit load through u2 must be for the load's geometric stiffness to be K0; the nine N
/// follow from K0r and K0omega, see modal_basis.hpp).  Put into the kinetic energy, to second order in s, it
/// makes C_t and B depend on s,
///
///     C_t,a = int Phi_a + K0t_a s,     B_ab = int x_a Phi_b + T_ab s + N_ab s,     Phi_k = Phi_k - K0F_k s
///
/// and adds s'^T K0t s' and s'^T N s' to force and torque.  So all stiffening terms (by acceleration, spin
/// and interface loads) act together, the mass matrix stays symmetric and the energy balance exact; to first
/// order in s it is the stiffness of Wallrapp and Schwertassek (Int. J. Numer. Meth. Eng. 32 (1991), 1833).
namespace flexura::mbs {

class ModalBody final : public FlexibleBody {
 public:
  /// A superelement, its modes chosen by the options; its interfaces are the nodes.  Throws std::runtime_error for a file
  /// that is no whole superelement, std::invalid_argument where no body can be made of it (modal_data()).
  static ModalBody read(const std::filesystem::path& file, const BasisOptions& options = {});
  explicit ModalBody(const superelement::Superelement& se, const BasisOptions& options = {});
  /// Throws std::invalid_argument when the sizes of the data disagree, or for stiffening without full coupling.
  explicit ModalBody(ModalData data);

  const ModalData& data() const { return data_; }
  const BasisReport& report() const {
    return report_;
  }  ///< modes kept, their frequencies [Hz]; of a superelement

  std::vector<LawError> error_sources() const override {
    return {{"modes", "a run of its superelement, added as a part, tells"}};
  }
  bool is_linear() const override { return true; }
  bool has_geometric_stiffness() const override { return data_.second.has_value(); }
  const ModalData* modal() const override { return &data_; }
  Spring spring(int i) const override { return {data_.stiffness(i), data_.damping(i)}; }
  double amplitude(int i) const override;
  RigidInertia undeformed_inertia() const override;

  std::unique_ptr<Scratch> make_scratch() const override;
  void set_position(const double* s, Scratch& scratch) const override;
  Spatial inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                           const Spatial& A, Scratch& scratch, double* need) const override;
  double strain_energy(const double* s) const override;
  double dissipated_power(const double* s, const double* s_dot) const override;
  Pose node_pose(int node, const double* s) const override;
  void node_motion(int node, const double* s, const double* s_dot, const double* s_ddot,
                   NodeMotion& out) const override;

  void turning_tangents(const double* s, const double* s_dot, const Vector3d& w, Scratch& scratch,
                        Eigen::Matrix<double, 6, 3>& need_w, Modal3& modal_w) const override;
  void deformation_tangents(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                            const Spatial& A, Scratch& scratch, DeformationTangents& out) const override;
  void node_tangents(int node, const double* s, const double* s_dot, const double* s_ddot,
                     const Vector6d& wrench, DeformationTangents& out) const override;
  void add_tangents(const double*, const double*, MatrixRef, MatrixRef D) const override;  // beside spring()

 private:
  struct Work final : Scratch {
    Eigen::VectorXd B;           ///< 9 m, block 3 a + b
    Eigen::VectorXd T_s;         ///< 9 m
    Eigen::VectorXd W;           ///< 3 m: int (Phi s') x Phi_i dm
    Eigen::VectorXd N_s, K0t_s;  ///< 9 m, 3 m
  };
  explicit ModalBody(std::pair<ModalData, BasisReport> made);

  ModalData data_;
  BasisReport report_;
  int m_;
  /// Rows 3 a + b of blocks T_ab with B_ab = int x_a Phi_,b + T_ab s: 9 m x m.
  Eigen::MatrixXd T_;
  /// Rows c of blocks T_ab - T_ba, (a, b, c) cyclic: 3 m x m.
  Eigen::MatrixXd T_skew_;
  Eigen::VectorXd B_0_;                                           ///< 9 m
  std::vector<Eigen::Matrix<double, 8, Eigen::Dynamic>> shapes_;  ///< of the nodes, for node_motion()
  Eigen::MatrixXd N_skew_;  ///< 3 m x m: N_ab - N_ba, (a, b, c) cyclic; empty without stiffening
};

}  // namespace flexura::mbs
