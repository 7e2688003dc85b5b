// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "beam/ancf/ancf_kinematics.hpp"
#include "beam/ancf/body.hpp"
#include "mbs/bodies/flexible_body.hpp"

/// A beam of the absolute nodal coordinate formulation as a body of a mechanism: it may bend as far as it
/// likes.
///
/// The nodes' positions and slopes (beam/ancf/body.hpp) are taken in the body's frame B, which is fixed to
/// the cross-section at the first node: r, r_y and r_z there are constant, and what is left of q - q_rest are
/// the coordinates s.  So the beam hangs in the tree of joints as any body does, and joints, constraints and
/// forces on its nodes are those of flexible bodies.  With rho = Q S(x) (one column of Q for each nodal
/// vector, m and w the integrals of S_i S_j and S_i over the mass, P = Q m)
///
///     d = Q w,   int rho rho^T dm = Q P^T,   C_t,i = w_i 1,   C_r,i = [P_i]x
///     modal_i = w_i a + alpha x P_i + w x (w x P_i) + 2 w x P'_i + P''_i + f_i(q, q')
///
/// M_e is constant; f is the beam's internal force, nonlinear and exact.  Where B is at rest these are the
/// equations in absolute coordinates.
///
/// A planar line (8 coordinates an element; A. L. Schwab, J. P. Meijaard, J. Comput. Nonlinear Dyn. 5 (2010) 011010) bends and
/// stretches in the plane of the axis and y alone, without shear, rotary inertia of its sections or anything across; B is
/// fixed to r and the direction of r_x at its first node.
namespace flexura::mbs {

class AncfPart final : public FlexibleBody {
 public:
  /// A place that markers can sit on.
  struct Station {
    std::string name;
    beam::ancf::MaterialPoint at;
  };

  /// `body` in its rest configuration, expressed in B.  Throws std::invalid_argument unless it is a spatial
  /// or a solid beam, or a planar line (spatial lines have no section frame to fix B to).
  AncfPart(beam::ancf::AncfBody body, std::vector<Station> stations);
  /// A planar line along the x axis of a plane whose axes in B are the columns x, y of R, its origin at `origin`.
  AncfPart(beam::ancf::AncfBody body, std::vector<Station> stations, const Matrix3d& R,
           const Vector3d& origin);

  const beam::ancf::AncfBody& beam() const { return body_; }
  /// The coordinate of the beam that s_i adds to.
  int coordinate(int i) const { return i < n_first_ ? body_.dim() + i : n_node_ - n_first_ + i; }
  /// The s_i that adds to a coordinate of the beam; -1 where that is fixed to B.
  int free_of(int coordinate) const;

  std::vector<LawError> error_sources() const override {
    return {{"elements", "a run with twice as many tells"}};
  }
  std::unique_ptr<Scratch> make_scratch() const override;
  void set_position(const double* s, Scratch& scratch) const override;
  Spatial inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                           const Spatial& A, Scratch& scratch, double* need) const override;
  double strain_energy(const double* s) const override;
  /// The largest angle between the axes r_y, or r_z, at the two ends of an element [rad].
  double largest_turn(const double* s) const;
  double dissipated_power(const double* s, const double* s_dot) const override;
  Pose node_pose(int node, const double* s) const override;
  void node_motion(int node, const double* s, const double* s_dot, const double* s_ddot,
                   NodeMotion& out) const override;
  /// Those of its element.
  std::pair<int, int> coordinates_of(int node) const override;
  void turning_tangents(const double* s, const double* s_dot, const Vector3d& w, Scratch& scratch,
                        Eigen::Matrix<double, 6, 3>& need_w, Modal3& modal_w) const override;
  void deformation_tangents(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                            const Spatial& A, Scratch& scratch, DeformationTangents& out) const override;
  void add_tangents(const double* s, const double* s_dot, MatrixRef K, MatrixRef D) const override;
  /// From the energy of the beam bent to an arc.
  double amplitude(int) const override { return 1.0; }  // lengths and slopes as they are
  std::optional<Vector3d> stiff_direction() const override;

 private:
  struct Work final : Scratch {
    Eigen::VectorXd q, v, f;          ///< n_q
    Eigen::Matrix3Xd Q, P, P_dot, F;  ///< a column for each nodal vector, in B
  };
  struct Rates {
    Vector3d d_dot;
    Matrix3d G;  ///< int rho_a rho'_b dm
  };
  Rates take_rates(const double* s_dot, Work& work) const;
  void expand(const double* s, bool from_rest, Eigen::VectorXd& q) const;
  void lift(const Eigen::VectorXd& q, Eigen::Matrix3Xd& Q) const;
  Eigen::MatrixXd in_plane(const Matrix3d& W) const;
  beam::ancf::PointKinematics evaluate(const beam::ancf::MaterialPoint& at, const Eigen::VectorXd& q,
                                       const Eigen::VectorXd& v) const;
  Vector3d axis(int coordinate) const { return R_.col(coordinate % body_.dim()); }
  int vector(int coordinate) const { return coordinate / body_.dim(); }
  void add_free(const beam::ancf::BlockTridiagonal& from, MatrixRef to) const;

  beam::ancf::AncfBody body_;
  std::vector<Station> stations_;
  Matrix3d R_ = Matrix3d::Identity();   ///< axes of the beam's coordinates in B
  Vector3d origin_ = Vector3d::Zero();  ///< and their origin
  int n_node_, n_first_;                ///< coordinates of a node; those of the first that B leaves free
  std::vector<Matrix3d> R_rest_;        ///< of the section at each station
  Eigen::VectorXd weight_;              ///< w, for each nodal vector
};

/// A prismatic beam: the 6 x 6 section stiffness of a straight line in B, `elements` equal elements.
/// Stations "root" and "tip", and those given by their distance from the root.
std::shared_ptr<const AncfPart> straight_ancf_part(
    const beam::ancf::BeamSection& section, const Vector3d& from_B, const Vector3d& to_B,
    const Vector3d& y_axis_B, int elements, const std::vector<std::pair<std::string, double>>& stations = {});

/// The planar line of the same ends, which bends in the plane of its axis and `y_axis_B`.
std::shared_ptr<const AncfPart> planar_ancf_part(
    const beam::ancf::LineSection& section, const Vector3d& from_B, const Matrix3d& R_BE, double length,
    int elements, const std::vector<std::pair<std::string, double>>& stations = {});

}  // namespace flexura::mbs
