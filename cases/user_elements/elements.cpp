// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "mbs/mechanism/user_element.hpp"

/// One force element, one constraint and one joint of a user's own: magnet, on_ellipsoid and parabola.
namespace {

using namespace flexura::mbs;

/// Two magnets that draw each other with strength / r^2; r below `core` counts as `core`.
class Magnet final : public ForceElement {
 public:
  explicit Magnet(const UserArguments& a)
      : ForceElement(a.name), strength_(a.value("strength")), core_(a.value("core", 1e-3)) {
    a.require_markers(2);
    P_ = a.markers[0];
    Q_ = a.markers[1];
  }
  std::string_view type() const override { return "magnet"; }
  std::pair<int, int> markers() const override { return {P_, Q_}; }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    const Vector3d r = kin.markers[Q_].X_WP.p - kin.markers[P_].X_WP.p;
    const double length = r.norm();
    const Vector3d pull = force(length) / length * r;
    loads.apply(P_, Spatial{Vector3d::Zero(), pull});
    loads.apply(Q_, Spatial{Vector3d::Zero(), -pull});
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    const double r = distance(kin);
    powers.potential += r > core_ ? -strength_ / r : strength_ * (r / (core_ * core_) - 2.0 / core_);
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"force", flexura::input::dim::force, "attraction"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    values[0] = force(distance(kin));
  }

 private:
  double distance(const Kinematics& kin) const {
    return (kin.markers[Q_].X_WP.p - kin.markers[P_].X_WP.p).norm();
  }
  double force(double r) const { return strength_ / std::pow(std::max(r, core_), 2); }

  int P_, Q_;
  double strength_, core_;
};

/// Mo stays on the ellipsoid (x/a)^2 + (y/b)^2 + (z/c)^2 = 1 about the axes of F.
class OnEllipsoid final : public RelativeRows {
 public:
  explicit OnEllipsoid(const UserArguments& a)
      : weights_(std::pow(a.value("a"), -2), std::pow(a.value("b"), -2), std::pow(a.value("c"), -2)) {
    a.require_markers(2);
  }
  int n_rows() const override { return 1; }
  std::string row_name(int) const override { return "surface"; }
  void constrain(Rows& rows) const override {
    // g = (p . W p - 1) / 2,   g' = p . W p',   g'' = p . W p'' + p' . W p'
    const Vector3d& p = rows.X_FM().p;
    const Vector3d u = rows.linear(), Wp = weights_.cwiseProduct(p);
    rows.add(0.5 * (p.dot(Wp) - 1.0), Vector3d::Zero(), Wp, u.dot(weights_.cwiseProduct(u)));
  }

 private:
  Vector3d weights_;
};

/// M slides along the parabola z = curvature x^2 / 2 in the xz plane of F and does not turn.  Coordinate: `x`
/// [m].
class Parabola final : public Joint {
 public:
  explicit Parabola(const UserArguments& a) : k_(a.value("curvature")) {}
  std::string_view type() const override { return "parabola"; }
  std::vector<CoordinateInfo> coordinates() const override { return {{"x", flexura::input::dim::length}}; }
  std::vector<CoordinateInfo> speeds() const override { return {{"v_x", flexura::input::dim::velocity}}; }
  std::vector<CoordinateInfo> accelerations() const override {
    return {{"a_x", flexura::input::dim::acceleration}};
  }
  int n_p() const override { return 1; }
  int n_v() const override { return 1; }
  Pose pose(const double* q) const override {
    return {Matrix3d::Identity(), {q[0], 0.0, 0.5 * k_ * q[0] * q[0]}};
  }
  void motion(const double* q, MotionMatrix& S) const override { S.col(0) << 0, 0, 0, 1, 0, k_ * q[0]; }
  Vector6d bias(const double*, const double* v) const override {
    return k_ * v[0] * v[0] * Vector6d::Unit(5);
  }
  void coordinates_of(const Pose& X, double* q) const override { q[0] = X.p.x(); }
  void speeds_of(const double*, const Vector6d& V, double* v) const override { v[0] = V(3); }

  // As the closure of a loop.
  void constrain(Rows& rows) const override {
    const Vector3d& p = rows.X_FM().p;
    rows.position_in_F(Vector3d::UnitY());
    rows.add(p.z() - 0.5 * k_ * p.x() * p.x(), Vector3d::Zero(), {-k_ * p.x(), 0.0, 1.0},
             -k_ * rows.linear().x() * rows.linear().x());
    for (int i = 0; i < 3; ++i) rows.angle(Vector3d::Unit((i + 2) % 3), Vector3d::Unit((i + 1) % 3));
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"y", "parabola", "rotation_x", "rotation_y", "rotation_z"};
    return names[i];
  }

 private:
  double k_;
};

}  // namespace

FLEXURA_ELEMENTS(elements) {
  elements.forces["magnet"] = [](const UserArguments& a) { return std::make_shared<Magnet>(a); };
  elements.constraints["on_ellipsoid"] = [](const UserArguments& a) {
    return std::make_shared<RelativeConstraint>(a.name, a.markers.at(0), a.markers.at(1),
                                                std::make_shared<OnEllipsoid>(a));
  };
  elements.joints["parabola"] = [](const UserArguments& a) { return std::make_shared<Parabola>(a); };
}
