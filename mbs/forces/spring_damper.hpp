// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/forces/force.hpp"

namespace flexura::mbs {

/// Along the line between two points P, Q of length L = |p_PQ|: tension
///
///     k (L - L_0) + f(L - L_0) + d L' + h(L') + preload,        f and h curves
class SpringDamper final : public ForceElement {
 public:
  struct Law {
    double stiffness = 0.0;                                       ///< k [N/m]
    double damping = 0.0;                                         ///< d [N s/m]
    double free_length = 0.0;                                     ///< L_0 [m]
    double preload = 0.0;                                         ///< [N]
    std::shared_ptr<const Curve> curve = {}, damping_curve = {};  ///< f, h
  };
  SpringDamper(std::string name, int P, int Q, Law law)
      : ForceElement(std::move(name)), P_(P), Q_(Q), law_(std::move(law)) {}
  std::string_view type() const override { return "spring_damper"; }
  /// What the free length and the curves hold at the start belongs to the structure.
  ForceNature nature() const override {
    return law_.preload != 0.0 ? ForceNature::load : ForceNature::response;
  }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double*) const override {
    auto rest = std::make_shared<SpringDamper>(*this);
    rest->law_.preload = 0.0;
    return rest;
  }
  std::pair<int, int> markers() const override { return {P_, Q_}; }

  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    const Line line = along(kin);
    const Vector3d f = tension(line) * line.direction;
    loads.apply(P_, Spatial{Vector3d::Zero(), f});
    loads.apply(Q_, Spatial{Vector3d::Zero(), -f});
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    const Relative rel = kin.relative_motion(P_, Q_);
    const double length = rel.X_FM.p.norm();
    if (length == 0.0) return;
    const Vector3d e = rel.X_FM.p / length, u = rel.V.tail<3>();
    const Line line{e, length, e.dot(u)};
    const double stretch = length - law_.free_length, T = tension(line);
    const double k = law_.stiffness + (law_.curve ? law_.curve->at(stretch).first : 0.0);
    const double c = law_.damping + (law_.damping_curve ? law_.damping_curve->at(line.rate).first : 0.0);
    // e' turns as e is pulled sideways: (1 - e e^T) / L.
    const Matrix3d turn = (Matrix3d::Identity() - e * e.transpose()) / length;
    Eigen::Matrix<double, 6, 12> W = Eigen::Matrix<double, 6, 12>::Zero();
    W.block<3, 3>(3, 3) = -e * (k * e + c * turn * u).transpose() - T * turn;
    W.block<3, 3>(3, 9) = -c * e * e.transpose();
    Vector6d on_Q;
    on_Q << Vector3d::Zero(), -T * e;
    d.between(P_, Q_, on_Q);
    d.by_relative(P_, Q_, W);
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    const Line line = along(kin);
    const double stretch = line.length - law_.free_length;
    powers.potential += 0.5 * law_.stiffness * stretch * stretch + law_.preload * line.length;
    powers.dissipated += law_.damping * line.rate * line.rate;
    if (law_.curve) powers.potential += law_.curve->integral(stretch);
    if (law_.damping_curve) powers.dissipated += (*law_.damping_curve)(line.rate) * line.rate;
  }
  std::vector<CurveLaw> curves() const override {
    std::vector<CurveLaw> out;
    if (law_.curve)
      out.push_back(
          {law_.curve, [this](const Kinematics& kin) { return along(kin).length - law_.free_length; }});
    if (law_.damping_curve)
      out.push_back({law_.damping_curve, [this](const Kinematics& kin) { return along(kin).rate; }});
    return out;
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"force", input::dim::force, "tension of the spring and damper"},
            {"length", input::dim::length, "distance of its ends"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    const Line line = along(kin);
    values[0] = tension(line);
    values[1] = line.length;
  }

 private:
  struct Line {
    Vector3d direction;
    double length, rate;
  };
  Line along(const Kinematics& kin) const {
    const MarkerState &P = kin.markers[P_], &Q = kin.markers[Q_];
    const Vector3d r = Q.X_WP.p - P.X_WP.p;
    Line line;
    line.length = r.norm();
    // Ends that coincide leave the direction open; there no force acts.
    line.direction = line.length > 0.0 ? Vector3d(r / line.length) : Vector3d::Zero();
    line.rate = line.direction.dot(Q.V.linear - P.V.linear);
    return line;
  }
  double tension(const Line& line) const {
    const double stretch = line.length - law_.free_length;
    double tension = law_.stiffness * stretch + law_.damping * line.rate + law_.preload;
    if (law_.curve) tension += (*law_.curve)(stretch);
    if (law_.damping_curve) tension += (*law_.damping_curve)(line.rate);
    return tension;
  }

  int P_, Q_;
  Law law_;
};

}  // namespace flexura::mbs
