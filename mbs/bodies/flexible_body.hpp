// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mbs/base/math/spatial.hpp"
#include "mbs/superelement/superelement.hpp"

/// A flexible body in its floating frame B (theory: Schwertassek and Wallrapp; Shabana).
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

/// The integrals of the second-order displacement, see above.
struct SecondOrderIntegrals {
  Eigen::MatrixXd t;  ///< 3 m x m: K0t_a
  Eigen::MatrixXd x;  ///< 9 m x m, block 3 a + b: N_ab
};

/// The body's integrals and stiffness in the modal coordinates s.
struct ModalData {
  superelement::InertiaIntegrals inertia;  ///< with the columns of the basis in place of the shapes
  Eigen::VectorXd stiffness;               ///< m: omega_i^2 for mass-normalised modes
  Eigen::VectorXd damping;                 ///< m: 2 zeta omega_i
  std::vector<FlexibleNode> nodes;
  Eigen::MatrixXd Y;  ///< n_se x m, u_se = Y s
  Coupling coupling = Coupling::full;
  std::optional<SecondOrderIntegrals> second = {};  ///< with geometric stiffening, which needs full coupling
};

/// How a node moves in its body: what a marker on it needs.
struct NodeMotion {
  Pose X_BN;     ///< the node's frame, parallel to B where the body is undeformed
  Spatial V, A;  ///< twist and acceleration relative to B, expressed in B
  Eigen::Matrix<double, 6, Eigen::Dynamic> map;  ///< 6 x m: V = map s'
  Eigen::VectorXd second, rates;                 ///< work space
};

struct DeformationTangents;

class FlexibleBody {
 public:
  /// What an evaluation leaves for the next: one of each body in the scratch of a mechanism.
  using MatrixRef = Eigen::Ref<Eigen::MatrixXd>;

  struct Work {
    Eigen::VectorXd q, v, f;     ///< of an ANCF beam
    Eigen::Matrix3Xd P;          ///< of an ANCF beam
    Eigen::VectorXd B;           ///< 9 m, block 3 a + b
    Eigen::VectorXd T_s;         ///< 9 m
    Eigen::VectorXd W;           ///< 3 m: int (Phi s') x Phi_i dm
    Eigen::VectorXd N_s, K0t_s;  ///< 9 m, 3 m
    Vector3d d = Vector3d::Zero();
    Matrix3d J = Matrix3d::Zero();
    Eigen::Matrix3Xd C_t;  ///< 3 x m: int Phi_i dm, with stiffening + K0t s
    Eigen::Matrix3Xd C_r;  ///< 3 x m: int rho x Phi_i dm, expressed in B
  };

  /// Throws std::invalid_argument when the sizes of the data disagree, or for stiffening without full
  /// coupling.
  explicit FlexibleBody(ModalData data);
  virtual ~FlexibleBody() = default;

  int m() const { return m_; }
  const ModalData& data() const { return data_; }
  double mass() const { return data_.inertia.mass; }
  int find_node(const std::string& name) const;  ///< -1 when there is none
  Work make_work() const;

  /// B, d, J, C_t and C_r of `work` at s.
  virtual void set_position(const double* s, Work& work) const;

  /// The mass block that does not depend on s: M_e (m x m).
  const Eigen::MatrixXd& M_e() const { return M_e_; }

  /// After set_position: wrench (about Bo) and modal forces that the motion needs, all in B, elastic and
  /// damping forces included.  V = (w_WB, anything), A = (alpha, a of Bo - g).
  virtual Spatial inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot,
                                   const Spatial& V, const Spatial& A, Work& work, double* modal) const;

  /// Derivatives of inverse_dynamics() by w (in B): of the wrench and of the modal forces.
  virtual void turning_tangents(const double* s, const double* s_dot, const Vector3d& w, Work& work,
                                Eigen::Matrix<double, 6, 3>& need_w,
                                Eigen::Matrix<double, Eigen::Dynamic, 3>& modal_w) const;

  /// The other derivatives of inverse_dynamics(), by s and s', at the state of the last set_position(work).
  void deformation_tangents(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                            const Spatial& A, Work& work, DeformationTangents& out) const;
  /// Those of node_motion(), and of map^T wrench at a fixed wrench (about the node, in B).
  void node_tangents(int node, const double* s, const double* s_dot, const double* s_ddot,
                     const Vector6d& wrench, DeformationTangents& out) const;
  DeformationTangents make_deformation_tangents() const;

  /// After set_position; V = (w_WB, v_WBo) in B.
  double kinetic_energy(const double* s_dot, const Spatial& V, const Work& work) const;
  virtual double strain_energy(const double* s) const;
  virtual double dissipated_power(const double* s, const double* s_dot) const;

  /// Pose of a node in B at s.
  virtual Pose node_pose(int node, const double* s) const;
  /// How a node moves; V and A only where s_dot and s_ddot are given (else nullptr).
  virtual void node_motion(int node, const double* s, const double* s_dot, const double* s_ddot,
                           NodeMotion& out) const;
  NodeMotion make_node_motion() const;

  /// True where s are modal coordinates: decoupled stiffness and damping in data(), deformations linear in s.
  virtual bool is_modal() const { return true; }
  /// Of a body that is not modal: adds to K and D (m x m) the derivatives of its internal forces by s and s'.
  virtual void add_tangents(const double* s, const double* s_dot, MatrixRef K, MatrixRef D) const;

  /// Largest displacement of a node, or 1/sqrt(mass), for unit s_i: its inverse is the size of s_i.
  virtual double amplitude(int i) const;

 protected:
  /// A body with another law of deformation: its mass, nodes (their places and names) and M_e (m x m).
  FlexibleBody(double mass, std::vector<FlexibleNode> nodes, Eigen::MatrixXd M_e);

 private:
  void difference_deformation(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                              const Spatial& A, DeformationTangents& out) const;
  void difference_node(int node, const double* s, const double* s_dot, const double* s_ddot,
                       const Vector6d& wrench, DeformationTangents& out) const;

  int m_;
  ModalData data_;
  Eigen::MatrixXd M_e_;
  /// Rows 3 a + b of blocks T_ab with B_ab = int x_a Phi_,b + T_ab s: 9 m x m.
  Eigen::MatrixXd T_;
  /// Rows c of blocks T_ab - T_ba, (a, b, c) cyclic: 3 m x m.
  Eigen::MatrixXd T_skew_;
  Eigen::VectorXd B_0_;                                           ///< 9 m
  std::vector<Eigen::Matrix<double, 8, Eigen::Dynamic>> shapes_;  ///< of the nodes, for node_motion()
  Eigen::MatrixXd N_skew_;  ///< 3 m x m: N_ab - N_ba, (a, b, c) cyclic; empty without stiffening
};

/// See FlexibleBody; those of a body that is not modal are central differences of its own functions, right to
/// about 1e-10 of their scale.
struct DeformationTangents {
  using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  // Of inverse_dynamics().
  Columns need_s, need_v;            ///< 6 x m: wrench by s and by s'
  Eigen::MatrixXd modal_s, modal_v;  ///< m x m: modal forces by s and by s'
  // Of one node's motion in B (V = map s' and A) and of its map.
  Columns motion_s, acceleration_s, acceleration_v;  ///< 6 x m: V by s, A by s and by s'; V by s' is the map
  Eigen::MatrixXd map_s;                             ///< m x m: map^T wrench by s

  // Work space.
  Eigen::VectorXd moved_s, moved_v, modal, T_v, turn;
  FlexibleBody::Work work;
  NodeMotion node;
};

}  // namespace flexura::mbs
