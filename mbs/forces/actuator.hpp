// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "mbs/forces/force.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// A motor, valve-driven cylinder or muscle: a force f (or torque) along a joint's coordinate or along the
/// line from P to Q, that follows its command with a lag and within its limits. With v the speed along it,
///
///     T f' = clamp(command, -F_max (1 + v / v_max), F_max (1 - v / v_max)) - f
///
/// so that a motor at its no-load speed v_max pushes no more, and one that is driven backwards brakes with
/// all it has (no limit's sign turns round: it is at least 0 forwards and at most 0 backwards).  f is a
/// dynamic state.
class Actuator final : public ForceElement {
 public:
  struct Law {
    std::shared_ptr<const Expression> command;
    double time_constant, start;
    double limit = std::numeric_limits<double>::infinity();
    double no_load_speed = std::numeric_limits<double>::infinity();
    input::Dimension along = input::dim::none;  ///< of a force along the coordinate, or the line
  };
  Actuator(std::string name, std::optional<CoordinateRef> coordinate, int P, int Q, Law law)
      : ForceElement(std::move(name)), coordinate_(coordinate), P_(P), Q_(Q), law_(std::move(law)) {}
  std::string_view type() const override { return "actuator"; }
  std::pair<int, int> markers() const override { return {P_, Q_}; }
  std::vector<CoordinateRef> coordinates() const override {
    return coordinate_ ? std::vector<CoordinateRef>{*coordinate_} : std::vector<CoordinateRef>{};
  }
  std::vector<int> reads() const override { return law_.command->reads(); }
  ForceNature nature() const override { return ForceNature::load; }
  /// The force that it is asked for, whatever it has at the start.
  std::shared_ptr<const ForceElement> without_load(const Kinematics& kin,
                                                   const double* signals) const override {
    auto rest = std::make_shared<Actuator>(*this);
    rest->load_ = allowed(kin, signals);
    rest->law_.start = 0.0;
    return rest;
  }
  int n_states() const override { return 1; }
  void start(double* c) const override { c[0] = law_.start; }
  void rates(const Kinematics& kin, const double* signals, double* c_rate) const override {
    c_rate[0] = (target(kin, signals) - kin.own.c[0]) / law_.time_constant;
  }

  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    const double f = kin.own.c[0];
    if (coordinate_) {
      loads.apply(*coordinate_, f);
      return;
    }
    const Vector3d pull = f * direction(kin);
    loads.apply(P_, Spatial{Vector3d::Zero(), -pull});
    loads.apply(Q_, Spatial{Vector3d::Zero(), pull});
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* signals, Derivatives& d) const override {
    using Row = Eigen::Matrix<double, 1, 12>;
    Row speed_by_motion = Row::Zero();
    if (coordinate_) {
      d.force(*coordinate_, kin.own.c[0]);
      d.by_state(0, 1.0);
    } else {
      const Relative rel = kin.relative_motion(P_, Q_);
      const double length = rel.X_FM.p.norm();
      if (length > 0.0) {
        const Vector3d e = rel.X_FM.p / length;
        const Matrix3d turn = (Matrix3d::Identity() - e * e.transpose()) / length;
        speed_by_motion.segment<3>(3) = (turn * rel.V.tail<3>()).transpose();
        speed_by_motion.tail<3>() = e.transpose();
        Vector6d on_Q = Vector6d::Zero(), by_state = Vector6d::Zero();
        by_state.tail<3>() = e;
        on_Q.tail<3>() = kin.own.c[0] * e;
        Eigen::Matrix<double, 6, 12> W = Eigen::Matrix<double, 6, 12>::Zero();
        W.block<3, 3>(3, 3) = kin.own.c[0] * turn;
        d.between(P_, Q_, on_Q);
        d.by_relative(P_, Q_, W);
        d.by_state(0, by_state);
      }
    }
    d.rate(0);
    d.by_state(0, -1.0 / law_.time_constant);
    const double command = law_.command->evaluate(signals), asked = allowed(kin, signals);
    if (asked == command) {
      d.by_formula(*law_.command, signals, 1.0 / law_.time_constant);
    } else if (asked != 0.0) {
      const double slope = -law_.limit / law_.no_load_speed / law_.time_constant;
      if (coordinate_)
        d.by_speed(*coordinate_, slope);
      else
        d.by_relative(P_, Q_, slope * speed_by_motion);
    }
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    powers.input += kin.own.c[0] * speed(kin);
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"force", law_.along, "along the coordinate, or the line between the markers"},
            {"command", law_.along, "what is asked for, within the limits"},
            {"speed", speed_dimension(), "along the coordinate, or the line between the markers"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double* signals, double* values) const override {
    values[0] = kin.own.c[0];
    values[1] = target(kin, signals);
    values[2] = speed(kin);
  }

 private:
  input::Dimension speed_dimension() const {
    return law_.along == input::dim::force    ? input::dim::velocity
           : law_.along == input::dim::torque ? input::dim::angular_velocity
                                              : input::dim::none;
  }
  Vector3d direction(const Kinematics& kin) const {
    const Vector3d r = kin.markers[Q_].X_WP.p - kin.markers[P_].X_WP.p;
    const double length = r.norm();
    return length > 0.0 ? Vector3d(r / length) : Vector3d::Zero();
  }
  double speed(const Kinematics& kin) const {
    if (coordinate_) return kin.speed(*coordinate_);
    return direction(kin).dot(kin.markers[Q_].V.linear - kin.markers[P_].V.linear);
  }
  double target(const Kinematics& kin, const double* signals) const { return allowed(kin, signals) - load_; }
  double allowed(const Kinematics& kin, const double* signals) const {
    const double command = law_.command->evaluate(signals);
    if (law_.limit == std::numeric_limits<double>::infinity()) return command;
    const double slack = speed(kin) / law_.no_load_speed;
    return std::clamp(command, std::min(0.0, -law_.limit * (1.0 + slack)),
                      std::max(0.0, law_.limit * (1.0 - slack)));
  }

  std::optional<CoordinateRef> coordinate_;
  int P_, Q_;
  Law law_;
  double load_ = 0.0;  ///< taken away
};

}  // namespace flexura::mbs
