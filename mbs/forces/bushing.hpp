// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "mbs/forces/force.hpp"

namespace flexura::mbs {

/// Elastic joint between markers F and M. With x = (p_FoMo, theta) in F, theta the rotation vector of R_FM,
/// |theta| < pi, the energy is x^T K x / 2 and the wrench on M, about Mo and in F,
///
///     force = -(K x + D V)_p,     torque = -J_l(theta)^-T (K x)_theta - (D V)_theta,     V = (p', w_FM)
///
/// and with a curve along one of the six directions its force f(x_i) is added, whose integral is its energy,
/// where J_l^-1 takes the angular velocity to theta': the elastic part is an exact gradient at any angle.
class Bushing final : public ForceElement {
 public:
  using Laws = std::array<std::shared_ptr<const Curve>, 6>;
  /// K and D translations first, in the axes of F; K symmetric.
  Bushing(std::string name, int F, int M, const Matrix6d& K, const Matrix6d& D, Laws curves = {})
      : ForceElement(std::move(name)), F_(F), M_(M), K_(K), D_(D), curves_(std::move(curves)) {}
  std::string_view type() const override { return "bushing"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::pair<int, int> markers() const override { return {F_, M_}; }

  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply_between(kin, F_, M_, on_M(kin));
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    // With t = J^-T e, e the elastic torque:  t' = J^-T (e' - J'^T t),  theta' = J^-1 w.
    const Relative rel = kin.relative_motion(F_, M_);
    const Vector6d x = deflection(rel.X_FM);
    const LeftJacobian J(x.tail<3>());
    const Matrix3d J_inverse = left_jacobian(x.tail<3>()).inverse();
    Matrix6d K = K_;
    Vector6d elastic = K_ * x;
    for (int i = 0; i < 6; ++i)
      if (curves_[i]) {
        K(i, i) += curves_[i]->at(x(i)).first;
        elastic(i) += (*curves_[i])(x(i));
      }
    const Vector3d t = J_inverse.transpose() * elastic.tail<3>();
    Eigen::Matrix<double, 6, 12> W;
    for (int j = 0; j < 6; ++j) {
      Vector6d dx = Vector6d::Zero();
      if (j < 3)
        dx.tail<3>() = J_inverse.col(j);
      else
        dx(j - 3) = 1.0;
      const Vector6d de = K * dx;
      Vector3d turned;
      for (int i = 0; i < 3; ++i) turned(i) = J.first(dx.tail<3>(), Vector3d::Unit(i)).dot(t);
      W.col(j) << -J_inverse.transpose() * (de.tail<3>() - turned), -de.head<3>();
    }
    W.rightCols<6>() << -D_.bottomRightCorner<3, 3>(), -D_.bottomLeftCorner<3, 3>(),
        -D_.topRightCorner<3, 3>(), -D_.topLeftCorner<3, 3>();
    d.between(F_, M_, on_M(kin));
    d.by_relative(F_, M_, W);
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    const Relative rel = kin.relative_motion(F_, M_);
    const Vector6d x = deflection(rel.X_FM), V = rates(rel);
    powers.potential += 0.5 * x.dot(K_ * x);
    for (int i = 0; i < 6; ++i)
      if (curves_[i]) powers.potential += curves_[i]->integral(x(i));
    powers.dissipated += V.dot(D_ * V);
  }
  std::vector<CurveLaw> curves() const override {
    std::vector<CurveLaw> out;
    for (int i = 0; i < 6; ++i)
      if (const auto& curve = curves_[static_cast<std::size_t>(i)])
        out.push_back({curve, [this, i](const Kinematics& kin) {
                         return deflection(kin.relative_motion(F_, M_).X_FM)(i);
                       }});
    return out;
  }
  std::vector<OutputInfo> outputs() const override {
    std::vector<OutputInfo> infos;
    for (const char* name : {"force_x", "force_y", "force_z"})
      infos.push_back({name, input::dim::force, "on the body of `to`, in the axes of `from`"});
    for (const char* name : {"torque_x", "torque_y", "torque_z"})
      infos.push_back({name, input::dim::torque, "on the body of `to`, in the axes of `from`"});
    return infos;
  }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    const Vector6d w = on_M(kin);
    for (int i = 0; i < 3; ++i) {
      values[i] = w(3 + i);
      values[3 + i] = w(i);
    }
  }

 private:
  static Vector6d deflection(const Pose& X) {
    Vector6d x;
    x << X.p, rotation_log(X.R);
    return x;
  }
  static Vector6d rates(const Relative& rel) {
    Vector6d V;
    V << rel.V.tail<3>(), rel.V.head<3>();
    return V;
  }
  /// Torque first, as Loads takes it.
  Vector6d on_M(const Kinematics& kin) const {
    const Relative rel = kin.relative_motion(F_, M_);
    const Vector6d x = deflection(rel.X_FM), viscous = D_ * rates(rel);
    Vector6d elastic = K_ * x;
    for (int i = 0; i < 6; ++i)
      if (curves_[i]) elastic(i) += (*curves_[i])(x(i));
    const Matrix3d J_inverse = left_jacobian(x.tail<3>()).inverse();
    Vector6d w;
    w << -J_inverse.transpose() * elastic.tail<3>() - viscous.tail<3>(),
        -elastic.head<3>() - viscous.head<3>();
    return w;
  }

  int F_, M_;
  Matrix6d K_, D_;
  Laws curves_;
};

}  // namespace flexura::mbs
