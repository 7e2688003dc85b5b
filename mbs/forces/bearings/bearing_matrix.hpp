// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/forces/force.hpp"

namespace flexura::mbs {

/// A bearing by its matrices: the shaft M turns freely about the z axis of the housing F and is held in the other five
/// directions. With p = p_FoMo, a the z axis of M, both in F, and V = (p', w_FM),
///
///     x = (p_x, p_y, p_z, -a_y, a_x),     u = (p'_x, p'_y, p'_z, w_x, w_y),     f = -(K x + D u)
///
/// f are the three forces and the two torques of small tilts; at any tilt the torque of the symmetric part of K is
/// a x (f_4, f_5 as they stand against a), the exact gradient of the energy x^T K x / 2.  What is not symmetric in K (a
/// fluid film) has no energy: its power is put in.
class BearingMatrix final : public ForceElement {
 public:
  using Matrix5 = Eigen::Matrix<double, 5, 5>;
  /// K and D: forces first, then torques about x and y; the symmetric part of D not negative.
  BearingMatrix(std::string name, int F, int M, const Matrix5& K, const Matrix5& D)
      : ForceElement(std::move(name)), F_(F), M_(M), K_(K), D_(D) {}
  std::string_view type() const override { return "bearing"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::pair<int, int> markers() const override { return {F_, M_}; }

  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply_between(kin, F_, M_, on_M(kin.relative_motion(F_, M_)));
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    const Relative rel = kin.relative_motion(F_, M_);
    const Vector3d a = rel.X_FM.R.col(2);
    const Vector3d m = moment(K_ * deflection(rel.X_FM));
    Eigen::Matrix<double, 6, 12> W = Eigen::Matrix<double, 6, 12>::Zero();
    for (int j = 0; j < 6; ++j) {
      const Vector3d da = j < 3 ? Vector3d(Vector3d::Unit(j).cross(a)) : Vector3d(Vector3d::Zero());
      Vector5 dx;
      dx << (j < 3 ? Vector3d(Vector3d::Zero()) : Vector3d(Vector3d::Unit(j - 3))), -da.y(), da.x();
      const Vector5 df = K_ * dx;
      W.col(j) << -(da.cross(m) + a.cross(moment(df))), -df.head<3>();
    }
    for (int j = 0; j < 5; ++j) {
      const Vector5 df = D_.col(j);
      W.col(j < 3 ? 9 + j : 3 + j) << -df(3), -df(4), 0.0, -df.head<3>();
    }
    d.between(F_, M_, on_M(rel));
    d.by_relative(F_, M_, W);
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    const Relative rel = kin.relative_motion(F_, M_);
    const Vector5 x = deflection(rel.X_FM), u = rates(rel);
    const Vector3d da = rel.V.head<3>().cross(Vector3d(rel.X_FM.R.col(2)));
    Vector5 x_rate;
    x_rate << rel.V.tail<3>(), -da.y(), da.x();
    powers.potential += 0.5 * x.dot(K_ * x);
    powers.input -= 0.5 * x_rate.dot((K_ - K_.transpose()) * x);
    powers.dissipated += u.dot(D_ * u);
  }
  std::vector<OutputInfo> outputs() const override {
    std::vector<OutputInfo> infos;
    for (const char* name : {"force_x", "force_y", "force_z"})
      infos.push_back({name, input::dim::force, "on the body of `to`, in the axes of `from`"});
    for (const char* name : {"torque_x", "torque_y"})
      infos.push_back({name, input::dim::torque, "on the body of `to`, in the axes of `from`"});
    return infos;
  }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    const Vector6d w = on_M(kin.relative_motion(F_, M_));
    for (int i = 0; i < 3; ++i) values[i] = w(3 + i);
    for (int i = 0; i < 2; ++i) values[3 + i] = w(i);
  }

 private:
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  static Vector5 deflection(const Pose& X) {
    Vector5 x;
    x << X.p, -X.R(1, 2), X.R(0, 2);
    return x;
  }
  static Vector5 rates(const Relative& rel) {
    Vector5 u;
    u << rel.V.tail<3>(), rel.V(0), rel.V(1);
    return u;
  }
  /// The energy's gradient by a, where that by x is f.
  static Vector3d moment(const Vector5& f) { return {f(4), -f(3), 0.0}; }
  /// Torque first, as Loads takes it.
  Vector6d on_M(const Relative& rel) const {
    const Vector3d a = rel.X_FM.R.col(2);
    const Vector5 elastic = K_ * deflection(rel.X_FM), viscous = D_ * rates(rel);
    Vector6d w;
    w << -a.cross(moment(elastic)), -elastic.head<3>() - viscous.head<3>();
    w(0) -= viscous(3);
    w(1) -= viscous(4);
    return w;
  }

  int F_, M_;
  Matrix5 K_, D_;
};

}  // namespace flexura::mbs
