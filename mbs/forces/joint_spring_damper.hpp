// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/forces/force.hpp"
#include "mbs/kinematics/robot_words.hpp"

namespace flexura::mbs {

/// Along a coordinate q of a joint: -k (q - q_0) - f(q - q_0) - d q' - h(q') - preload, f and h curves.  On a
/// revolute joint a torsion spring.
class JointSpringDamper final : public ForceElement, public HasRobotWords {
 public:
  /// N and m along a coordinate that is a length, N m and rad about one that is an angle.
  struct Law {
    double stiffness = 0.0;  ///< k
    double damping = 0.0;    ///< d
    double rest = 0.0;       ///< q_0
    double preload = 0.0;
    std::shared_ptr<const Curve> curve = {}, damping_curve = {};  ///< f, h
  };
  /// `along`: dimension of a force along the coordinate.
  JointSpringDamper(std::string name, CoordinateRef c, Law law, input::Dimension along = input::dim::none)
      : ForceElement(std::move(name)), c_(c), law_(std::move(law)), along_(along) {}
  std::string_view type() const override { return "joint_spring_damper"; }
  /// What the free length and the curves hold at the start belongs to the structure.
  ForceNature nature() const override {
    return law_.preload != 0.0 ? ForceNature::load : ForceNature::response;
  }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double*) const override {
    auto rest = std::make_shared<JointSpringDamper>(*this);
    rest->law_.preload = 0.0;
    return rest;
  }
  std::vector<CoordinateRef> coordinates() const override { return {c_}; }
  /// A damper; a spring has no word there.
  std::optional<JointWords> joint_words() const override {
    if (law_.stiffness != 0.0 || law_.preload != 0.0 || law_.curve || law_.damping_curve) return std::nullopt;
    return JointWords{.coordinate = c_, .damping = law_.damping};
  }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply(c_, force(kin));
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    const double x = kin.coordinate(c_) - law_.rest, v = kin.speed(c_);
    d.force(c_, force(kin));
    d.by_coordinate(c_, -law_.stiffness - (law_.curve ? law_.curve->at(x).first : 0.0));
    d.by_speed(c_, -law_.damping - (law_.damping_curve ? law_.damping_curve->at(v).first : 0.0));
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    const double q = kin.coordinate(c_), v = kin.speed(c_);
    powers.potential += 0.5 * law_.stiffness * (q - law_.rest) * (q - law_.rest) + law_.preload * q;
    powers.dissipated += law_.damping * v * v;
    if (law_.curve) powers.potential += law_.curve->integral(q - law_.rest);
    if (law_.damping_curve) powers.dissipated += (*law_.damping_curve)(v)*v;
  }
  std::vector<CurveLaw> curves() const override {
    std::vector<CurveLaw> out;
    if (law_.curve)
      out.push_back({law_.curve, [this](const Kinematics& kin) { return kin.coordinate(c_) - law_.rest; }});
    if (law_.damping_curve)
      out.push_back({law_.damping_curve, [this](const Kinematics& kin) { return kin.speed(c_); }});
    return out;
  }
  std::vector<OutputInfo> outputs() const override { return {{"force", along_, "along the coordinate"}}; }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    values[0] = force(kin);
  }

 private:
  double force(const Kinematics& kin) const {
    const double x = kin.coordinate(c_) - law_.rest, v = kin.speed(c_);
    double f = -law_.stiffness * x - law_.damping * v - law_.preload;
    if (law_.curve) f -= (*law_.curve)(x);
    if (law_.damping_curve) f -= (*law_.damping_curve)(v);
    return f;
  }
  CoordinateRef c_;
  Law law_;
  input::Dimension along_;
};

}  // namespace flexura::mbs
