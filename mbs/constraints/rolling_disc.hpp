// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "mbs/constraints/constraint.hpp"

namespace flexura::mbs {

/// A thin disc of radius r, centred at Mo with the axis a = z of M, rolls without slip on the xy plane of F
/// (normal n).
///
/// Everything is seen from F. The lowest point lies at c = p + r e with
///     e = (u a - n) / w,   u = n . a,   w = sqrt(1 - u^2)
/// Rows: n . c = 0 (holonomic), and the velocity of the material point there, p' + r w_FM x e, has no
/// component along x and y of F (not holonomic: their position residual is zero). A disc that lies flat (w =
/// 0) has no lowest point.
class RollingDisc final : public Constraint {
 public:
  RollingDisc(std::string name, int F, int M, double radius)
      : Constraint(std::move(name)), F_(F), M_(M), radius_(radius) {}
  int n_rows() const override { return 3; }
  std::string row_name(int i) const override {
    static const char* names[] = {"height", "slip_x", "slip_y"};
    return names[i];
  }
  bool is_holonomic(int row) const override { return row == 0; }
  std::vector<int> markers() const override { return {F_, M_}; }

  void position(const Kinematics& kin, double* g) const override {
    const Pose X = kin.relative_pose(F_, M_);
    g[0] = X.p.z() + radius_ * to_contact(X).z();
    g[1] = g[2] = 0.0;
  }
  void velocity(const Kinematics& kin, double* g_dot) const override {
    const Relative rel = kin.relative_motion(F_, M_);
    // e' = w x e + a part along the rim, which is level: the height moves as the material point does.
    const Vector3d v = rel.V.tail<3>() + radius_ * rel.V.head<3>().cross(to_contact(rel.X_FM));
    g_dot[0] = v.z();
    g_dot[1] = v.x();
    g_dot[2] = v.y();
  }
  void acceleration(const Kinematics& kin, double* g_ddot) const override {
    const Relative rel = kin.relative_acceleration(F_, M_);
    const Vector3d w = rel.V.head<3>(), alpha = rel.A.head<3>(), e = to_contact(rel.X_FM);
    const Vector3d e_dot = contact_rate(rel.X_FM, e, w);
    const Vector3d v_dot = rel.A.tail<3>() + radius_ * (alpha.cross(e) + w.cross(e_dot));
    g_ddot[0] = v_dot.z();
    g_ddot[1] = v_dot.x();
    g_ddot[2] = v_dot.y();
  }
  void apply_GT(const Kinematics& kin, const double* x, Loads& loads) const override {
    const Vector3d f(x[1], x[2], x[0]);
    Vector6d on_M;
    on_M << radius_ * to_contact(kin.relative_pose(F_, M_)).cross(f), f;
    loads.apply_between(kin, F_, M_, on_M);
  }
  std::vector<OutputInfo> outputs() const override { return wrench_outputs(true, true); }
  void evaluate_outputs(const Kinematics& kin, const double* x, double* values) const override {
    const Vector3d f(-x[1], -x[2], -x[0]);
    Vector6d on_M;
    on_M << radius_ * to_contact(kin.relative_pose(F_, M_)).cross(f), f;
    put_wrench(on_M, true, true, values);
  }

  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* x, Derivatives& d) const override {
    const Relative rel = kin.relative_motion(F_, M_);
    const Vector3d w = rel.V.head<3>(), e = to_contact(rel.X_FM), f(x[1], x[2], x[0]);
    Eigen::Matrix<double, 6, 12> load = Eigen::Matrix<double, 6, 12>::Zero();
    Eigen::Matrix<double, 3, 12> v = Eigen::Matrix<double, 3, 12>::Zero();
    for (int j = 0; j < 3; ++j) {
      const Vector3d e_j = contact_rate(rel.X_FM, e, Vector3d::Unit(j));
      load.col(j).head<3>() = radius_ * e_j.cross(f);
      v.col(j) = radius_ * w.cross(e_j);
      v.col(6 + j) = radius_ * Vector3d::Unit(j).cross(e);
      v.col(9 + j) = Vector3d::Unit(j);
    }
    Vector6d on_M;
    on_M << radius_ * e.cross(f), f;
    d.between(F_, M_, on_M);
    d.by_relative(F_, M_, load);
    Eigen::Matrix<double, 3, 12> rates;
    rates << v.row(2), v.row(0), v.row(1);
    d.rows();
    d.by_relative(F_, M_, rates);
  }

 private:
  /// e' as the disc turns with w.
  Vector3d contact_rate(const Pose& X_FM, const Vector3d& e, const Vector3d& w) const {
    const Vector3d a = X_FM.R.col(2), a_dot = w.cross(a);
    const double u = a.z(), u_dot = a_dot.z(), root = steepness(a);
    return (u_dot * a + u * a_dot) / root + u * u_dot / (root * root) * e;
  }
  /// e: from the centre to the lowest point of the rim, a unit vector in F.
  Vector3d to_contact(const Pose& X_FM) const {
    const Vector3d a = X_FM.R.col(2), n = Vector3d::UnitZ();
    return (n.dot(a) * a - n) / steepness(a);
  }
  /// w, 0 where the disc lies flat: there all its rim is lowest.
  double steepness(const Vector3d& a) const {
    // The contact runs round the rim at 1 / w of the disc's own speeds: 3,000 times as fast there, where integrators
    // fail at the latest and no rim is that straight.
    constexpr double kFlat = 3e-4;
    const double w = std::hypot(a.x(), a.y());
    if (!(w > kFlat))
      throw std::runtime_error(
          fmt::format("the rolling disc \"{}\" lies flat on its plane (to {} rad), where all its rim touches "
                      "and its contact "
                      "point is undefined: end the run before it falls, give it a speed that keeps it up, or "
                      "let a contact "
                      "carry its rim",
                      name(), kFlat));
    return w;
  }

  int F_, M_;
  double radius_;
};

}  // namespace flexura::mbs
