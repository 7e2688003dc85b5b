// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mbs/base/documents/units.hpp"
#include "mbs/base/math/rotation.hpp"
#include "mbs/base/math/spatial.hpp"

/// A joint type leads two lives.
///
/// As an edge of the tree it gives motion: the pose of the outboard frame M in the inboard frame F and its
/// twist
///
///     X_FM(q),     V_FM = S(q) v,     V_FM' = S v' + bias(q, v),     q' = N(q) v
///
/// As the closure of a loop it takes motion away: rows on the relative pose of the same two frames
///
///     g(X_FM) = 0,     g' = G V_FM,     g'' = G V_FM' + gamma(X_FM, V_FM)
///
/// In both, V_FM = (w_FM_F, d/dt p_FoMo_F) is expressed in F, angular part first.
/// Adding a joint: one file in mbs/joints with both lives, one line in make_joint.cpp, one entry in
/// mbs/file/elements/joints.cpp.
namespace flexura::mbs {

/// 6 x n with its storage inside.
using MotionMatrix = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;

/// R turned by `angle` about z.
inline Matrix3d rotation_about_z(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Matrix3d R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R;
}

/// The angle of a rotation about z; of any other rotation the nearest one's.
inline double angle_about_z(const Matrix3d& R) {
  return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
}

/// Derivatives of angle_about_z as R turns with the angular velocity w (in the frame R maps into):
/// angle' = gradient . w,   angle'' = gradient . w' + bias.
struct TurnAboutZ {
  TurnAboutZ(const Matrix3d& R, const Vector3d& w) {
    const Vector3d x = R.col(0), y = R.col(1);
    // angle = atan2(s, c), s = x_y - y_x, c = x_x + y_y; x' = w x x.
    const double s = x.y() - y.x(), c = x.x() + y.y(), r2 = s * s + c * c;
    s_gradient = Vector3d(-x.z(), -y.z(), x.x() + y.y());
    const Vector3d c_gradient(-y.z(), x.z(), y.x() - x.y());
    const Vector3d xx = w.cross(w.cross(x)), yy = w.cross(w.cross(y));
    s_bias = xx.y() - yy.x();
    const double c_bias = xx.x() + yy.y();
    gradient = (c * s_gradient - s * c_gradient) / r2;
    const double s_rate = s_gradient.dot(w), c_rate = c_gradient.dot(w);
    bias = (c * s_bias - s * c_bias) / r2 - 2.0 * (c * c_rate + s * s_rate) * gradient.dot(w) / r2;
  }
  Vector3d gradient, s_gradient;
  double bias, s_bias;
};

/// Rows on a relative pose, collected one by one.
class Rows {
 public:
  Rows(const Pose& X_FM, const Vector6d& V_FM) : X_(X_FM), V_(V_FM) {}

  /// Component of p_FoMo along a vector `e` fixed in F, less `target`.
  void position_in_F(const Vector3d& e, double target = 0.0) {
    add(e.dot(X_.p) - target, Vector3d::Zero(), e, 0.0);
  }
  /// Component of p_FoMo along the vector `e` fixed in M: g = p . R e.
  void position_in_M(const Vector3d& e) {
    const Vector3d Re = X_.R * e, w = angular(), u = linear();
    const Vector3d w_x_Re = w.cross(Re);
    // g' = u . Re + w . (Re x p);  g'' adds 2 u . (w x Re) + p . (w x (w x Re)).
    add(X_.p.dot(Re), Re.cross(X_.p), Re, 2.0 * u.dot(w_x_Re) + X_.p.dot(w.cross(w_x_Re)));
  }
  /// g = a . R b - cosine, for a fixed in F and b fixed in M.
  void angle(const Vector3d& a, const Vector3d& b, double cosine = 0.0) {
    const Vector3d Rb = X_.R * b, w = angular();
    add(a.dot(Rb) - cosine, Rb.cross(a), Vector3d::Zero(), a.dot(w.cross(w.cross(Rb))));
  }
  /// g = (R_10 - R_01) / 2: no rotation about z beside a bending about an axis in the xy plane.
  void twist() {
    const TurnAboutZ turn(X_.R, angular());
    add(0.5 * (X_.R(1, 0) - X_.R(0, 1)), 0.5 * turn.s_gradient, Vector3d::Zero(), 0.5 * turn.s_bias);
  }
  /// g = |p_FoMo|^2 / (2 length) - length / 2, which has unit slope along the line.
  void distance(double length) {
    const Vector3d u = linear();
    add(0.5 * (X_.p.squaredNorm() / length - length), Vector3d::Zero(), X_.p / length,
        u.squaredNorm() / length);
  }
  /// A row made elsewhere: g, its derivative by (w, p') and the bias of g''.
  void add(double residual, const Vector3d& by_angular, const Vector3d& by_linear, double bias) {
    g(n) = residual;
    G.row(n) << by_angular.transpose(), by_linear.transpose();
    gamma(n) = bias;
    ++n;
  }

  const Pose& X_FM() const { return X_; }
  Vector3d angular() const { return V_.head<3>(); }
  Vector3d linear() const { return V_.tail<3>(); }

  int n = 0;
  double* contact = nullptr;  ///< see OwnStates::contact
  Vector6d g = Vector6d::Zero();
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> G = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>::Zero();
  Vector6d gamma = Vector6d::Zero();

 private:
  const Pose& X_;
  const Vector6d& V_;
};

/// What restrains the relative motion of two frames.
class RelativeRows {
 public:
  virtual ~RelativeRows() = default;
  virtual int n_rows() const = 0;
  virtual void constrain(Rows& rows) const = 0;
  /// What is open between the frames where row i is g [m or rad].
  virtual double gap(int /*row*/, double g) const { return g; }
  /// "x", "parallel_1": completes "name of the joint . ".
  virtual std::string row_name(int i) const = 0;
  /// The parameter of a contact that travels along a curve is an algebraic state a with 0 =
  /// contact_residual(a).
  virtual bool has_contact() const { return false; }
  virtual double contact_residual(const Pose& /*X_FM*/, double /*a*/) const { return 0.0; }
  /// Its derivatives by p_FoMo and by a.
  virtual Eigen::Vector4d contact_derivatives(const Pose& /*X_FM*/, double /*a*/) const {
    return Eigen::Vector4d::Zero();
  }
  /// True for one row that acts along the line of the origins: a massless link.
  virtual bool is_link() const { return false; }
  /// Its value at an assembled position.
  virtual double start_contact(const Pose& /*X_FM*/) const { return 0.0; }
};

/// Name and kind of a coordinate or speed.
struct CoordinateInfo {
  std::string name;
  input::Dimension dimension;
};

/// How the columns and the bias of a joint change: by q_j with q moved along the tangent coordinate j
/// (Joint::retract), and by v.
struct MotionDerivatives {
  std::array<MotionMatrix, 6> S_q;  ///< dS/dq_j
  MotionMatrix bias_q, bias_v;      ///< 6 x n_v
};

class Joint : public RelativeRows {
 public:
  virtual std::string_view type() const = 0;
  virtual std::vector<CoordinateInfo> coordinates() const = 0;    ///< n_p of them
  virtual std::vector<CoordinateInfo> speeds() const = 0;         ///< n_v of them
  virtual std::vector<CoordinateInfo> accelerations() const = 0;  ///< n_v of them
  virtual int n_p() const = 0;
  virtual int n_v() const = 0;
  int n_rows() const override { return 6 - n_v(); }

  virtual Pose pose(const double* q) const = 0;
  /// Sets the columns of S (6 x n_v).
  virtual void motion(const double* q, MotionMatrix& S) const = 0;
  virtual Vector6d bias(const double* /*q*/, const double* /*v*/) const { return Vector6d::Zero(); }
  /// True where S is one matrix for all q and there is no bias.
  virtual bool has_constant_motion() const { return false; }
  /// Asked only where the motion is not constant.  A joint that does not know is differenced by itself: the
  /// error is about 1e-10 of the entries' scale.
  virtual void motion_derivatives(const double* q, const double* v, MotionDerivatives& d) const;
  virtual void kinematic(const double* /*q*/, const double* w, double* q_dot) const {
    for (int i = 0; i < n_v(); ++i) q_dot[i] = w[i];
  }
  virtual void retract(const double* q, const double* d, double* q_out) const {
    for (int i = 0; i < n_v(); ++i) q_out[i] = q[i] + d[i];
  }
  /// The coordinates of a relative pose that the joint allows (of another pose: of the nearest, roughly).
  virtual void coordinates_of(const Pose& X_FM, double* q) const = 0;
  /// The speeds of a relative twist that the joint allows.
  virtual void speeds_of(const double* q, const Vector6d& V_FM, double* v) const = 0;
  /// The coordinates of coinciding frames.
  virtual void reference(double* q) const {
    for (int i = 0; i < n_p(); ++i) q[i] = 0.0;
  }
};

/// Makes a joint by its name, with what it can be given at its defaults.  Throws std::invalid_argument for an unknown one.
std::unique_ptr<Joint> make_joint(const std::string& type);

}  // namespace flexura::mbs
