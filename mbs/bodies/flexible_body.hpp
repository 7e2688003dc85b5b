// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mbs/base/math/spatial.hpp"

/// A body that deforms, in a frame B that moves with it: what a mechanism asks of any fidelity.
///
/// The deformation is described by m coordinates s.  With rho(s) where a particle stands in B, phi_i = d rho / d s_i and
///
///     d   = int rho dm,        J   = int |rho|^2 1 - rho rho^T dm
///     C_t = int phi_i dm,      C_r = int rho x phi_i dm,      M_e = int phi_i . phi_j dm
///
/// the kinetic energy of a motion (w, v) of B and s' is
///
///     m v^2 / 2 + v . (w x d) + w . J w / 2 + v . C_t s' + w . C_r s' + s' . M_e s' / 2
///
/// M_e does not depend on s where rho is linear in it (to the order that is kept); else set_position() takes it
/// (M_e(scratch)).  A mechanism takes the mass matrix and the momenta from these integrals and everything else from
/// inverse_dynamics().
///
/// A new fidelity derives from FlexibleBody, says what is pure here, and has one line in mbs/file/fidelities.cpp.
/// Derivatives that it does not give itself are central differences of its own functions, right to about 1e-10 of
/// their scale.
namespace flexura::mbs {

struct ModalData;

/// A place of the body that markers can sit on, and where it is undeformed [m].
struct NodePlace {
  std::string name;
  Vector3d p_BoN_B = Vector3d::Zero();
};

/// How a node moves in its body: what a marker on it needs.
struct NodeMotion {
  Pose X_BN;     ///< the node's frame, parallel to B where the body is undeformed
  Spatial V, A;  ///< twist and acceleration relative to B, expressed in B
  Eigen::Matrix<double, 6, Eigen::Dynamic> map;  ///< 6 x m: V = map s'
  Eigen::VectorXd second, rates;                 ///< work space
};

struct DeformationTangents;

/// An error that a law of deformation has by itself.
struct LawError {
  std::string kind;    ///< "modes": those it lacks; "elements": how many it has; "law": anything else
  std::string remedy;  ///< how a user can judge it where no estimate does
};

class FlexibleBody {
 public:
  using MatrixRef = Eigen::Ref<Eigen::MatrixXd>;
  using Modal3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  /// What an evaluation leaves for the next: one of each body in the scratch of a mechanism.  A fidelity derives its own.
  struct Scratch {
    virtual ~Scratch() = default;
    Vector3d d = Vector3d::Zero();
    Matrix3d J = Matrix3d::Zero();
    Eigen::Matrix3Xd C_t, C_r;  ///< 3 x m
  };
  /// The part of an internal force -(stiffness s_i + damping s'_i) that coordinate i has to itself.
  struct Spring {
    double stiffness = 0.0, damping = 0.0;
  };

  virtual ~FlexibleBody() = default;

  /// What the law leaves out, for the errors that a run tells of itself: what no estimate looks at there is unknown.  Every law
  /// answers; an exact one with none.
  virtual std::vector<LawError> error_sources() const = 0;

  // ---- What it is.
  int m() const { return static_cast<int>(M_e_.rows()); }
  double mass() const { return mass_; }
  const std::vector<NodePlace>& nodes() const { return nodes_; }
  int find_node(const std::string& name) const;        ///< -1 when there is none
  const Eigen::MatrixXd& M_e() const { return M_e_; }  ///< of the undeformed body

  /// False where the deformation follows the motion without acting back on it (one_way_body.hpp): the mechanism moves as
  /// with the rigid body, markers stay in their undeformed places, and (s, s') are dynamic states with s'' = -need, where
  /// need is what inverse_dynamics() asks for at s'' = 0 less the loads on the undeformed nodes; M_e is then 1.
  virtual bool acts_back() const { return true; }
  /// True where displacements are linear in s, so that they are right for small deformations only.
  virtual bool is_linear() const { return false; }
  /// False where its stiffness does not know of the loads that it bears.
  virtual bool has_geometric_stiffness() const { return true; }
  /// Where it deforms in a plane alone: the plane's normal, in B.
  virtual std::optional<Vector3d> stiff_direction() const { return std::nullopt; }
  /// What is known of it in modal coordinates; nullptr where it has none.
  virtual const ModalData* modal() const { return nullptr; }
  /// Of coordinate i; what internal forces there are beside them add_tangents() differentiates.
  virtual Spring spring(int /*i*/) const { return {}; }
  /// What coordinate i does by itself, nothing hanging on what it deforms.
  struct Alone {
    double reach = 0.0;  ///< largest displacement, turning counted by the length that it deforms [m]
    double mass = 0.0;   ///< its diagonal in the mass matrix
  };
  /// Where it deforms a part of the body alone, and moves all that is beyond: then M_e knows of more.
  virtual std::optional<Alone> alone(int /*i*/) const { return std::nullopt; }
  /// Largest displacement of a node, or 1/sqrt(mass), for unit s_i: its inverse is the size of s_i.
  virtual double amplitude(int i) const;
  /// Of the undeformed body, about Bo in B.
  virtual RigidInertia undeformed_inertia() const;

  // ---- What it does; s, s', s'' hold m numbers each.
  virtual std::unique_ptr<Scratch> make_scratch() const;
  /// The integrals of `scratch` at s.
  virtual void set_position(const double* s, Scratch& scratch) const = 0;
  /// M_e at the s of the last set_position(scratch).
  virtual const Eigen::MatrixXd& M_e(const Scratch& /*scratch*/) const { return M_e_; }
  /// False where inverse_dynamics() does without set_position(): whoever wants the integrals then calls it.
  virtual bool moves_by_integrals() const { return true; }
  /// After set_position (but see above): wrench (about Bo) and generalised forces (m) that the motion needs, all in B, elastic and
  /// damping forces included.  V = (w_WB, anything), A = (alpha, a of Bo - g).
  virtual Spatial inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot,
                                   const Spatial& V, const Spatial& A, Scratch& scratch,
                                   double* need) const = 0;
  /// After set_position; V = (w_WB, v_WBo) in B.
  double kinetic_energy(const double* s_dot, const Spatial& V, const Scratch& scratch) const;
  virtual double strain_energy(const double* s) const = 0;
  virtual double dissipated_power(const double* s, const double* s_dot) const = 0;

  /// Pose of a node in B at s.
  virtual Pose node_pose(int node, const double* s) const;
  /// How a node moves; V and A only where s_dot and s_ddot are given (else nullptr).
  virtual void node_motion(int node, const double* s, const double* s_dot, const double* s_ddot,
                           NodeMotion& out) const = 0;
  NodeMotion make_node_motion() const;
  /// The coordinates that move a node: [first, end) of s.
  virtual std::pair<int, int> coordinates_of(int /*node*/) const { return {0, m()}; }

  // ---- Derivatives.
  /// Of inverse_dynamics() by w (in B): of the wrench and of the generalised forces (m x 3).
  virtual void turning_tangents(const double* s, const double* s_dot, const Vector3d& w, Scratch& scratch,
                                Eigen::Matrix<double, 6, 3>& need_w, Modal3& modal_w) const;
  /// Of inverse_dynamics() by s and s', at the state of the last set_position(scratch).
  virtual void deformation_tangents(const double* s, const double* s_dot, const double* s_ddot,
                                    const Spatial& V, const Spatial& A, Scratch& scratch,
                                    DeformationTangents& out) const;
  /// Of node_motion(), and of map^T wrench at a fixed wrench (about the node, in B).
  virtual void node_tangents(int node, const double* s, const double* s_dot, const double* s_ddot,
                             const Vector6d& wrench, DeformationTangents& out) const;
  /// Adds to K and D (m x m) the derivatives by s and s' of the internal forces beside spring().
  virtual void add_tangents(const double* s, const double* s_dot, MatrixRef K, MatrixRef D) const;
  DeformationTangents make_deformation_tangents() const;

 protected:
  FlexibleBody(double mass, std::vector<NodePlace> nodes, Eigen::MatrixXd M_e);

 private:
  double mass_;
  std::vector<NodePlace> nodes_;
  Eigen::MatrixXd M_e_;
};

/// See FlexibleBody.
struct DeformationTangents {
  using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  // Of inverse_dynamics().
  Columns need_s, need_v;            ///< 6 x m: wrench by s and by s'
  Eigen::MatrixXd modal_s, modal_v;  ///< m x m: generalised forces by s and by s'
  // Of one node's motion in B (V = map s' and A) and of its map.
  Columns motion_s, acceleration_s, acceleration_v;  ///< 6 x m: V by s, A by s and by s'; V by s' is the map
  Eigen::MatrixXd map_s;                             ///< m x m: map^T wrench by s

  // Work space.
  Eigen::VectorXd moved_s, moved_v, modal, T_v, turn;
  std::unique_ptr<FlexibleBody::Scratch> scratch;
  NodeMotion node;
};

}  // namespace flexura::mbs
