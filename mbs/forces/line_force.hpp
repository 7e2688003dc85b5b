// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/forces/force.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// Along the line between two points P, Q: a force f by a formula, positive where it pushes them apart.
class LineForce final : public ForceElement {
 public:
  LineForce(std::string name, int P, int Q, std::shared_ptr<const Expression> value)
      : ForceElement(std::move(name)), P_(P), Q_(Q), value_(std::move(value)) {}
  std::string_view type() const override { return "line_force"; }
  std::pair<int, int> markers() const override { return {P_, Q_}; }
  std::vector<int> reads() const override { return value_->reads(); }
  ForceNature nature() const override { return ForceNature::load; }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double* signals) const override {
    auto rest = std::make_shared<LineForce>(*this);
    rest->load_ = value_->evaluate(signals);
    return rest;
  }

  void apply(const Kinematics& kin, const double* signals, Loads& loads) const override {
    const Vector3d f = value(signals) * along(kin).direction;
    loads.apply(P_, Spatial{Vector3d::Zero(), -f});
    loads.apply(Q_, Spatial{Vector3d::Zero(), f});
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* signals, Derivatives& d) const override {
    const Vector3d r = kin.relative_pose(P_, Q_).p;
    const double length = r.norm(), f = value(signals);
    if (length == 0.0) return;
    const Vector3d e = r / length;
    Vector6d unit = Vector6d::Zero();
    unit.tail<3>() = e;
    Eigen::Matrix<double, 6, 12> W = Eigen::Matrix<double, 6, 12>::Zero();
    W.block<3, 3>(3, 3) = f / length * (Matrix3d::Identity() - e * e.transpose());
    d.between(P_, Q_, f * unit);
    d.by_relative(P_, Q_, W);
    d.by_formula(*value_, signals, unit);
  }
  void add_powers(const Kinematics& kin, const double* signals, Powers& powers) const override {
    powers.input += value(signals) * along(kin).rate;
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"force", input::dim::force, "along the line, positive where it pushes its ends apart"},
            {"length", input::dim::length, "distance of its ends"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double* signals, double* values) const override {
    values[0] = value(signals);
    values[1] = along(kin).length;
  }

 private:
  struct Line {
    Vector3d direction;
    double length, rate;
  };
  Line along(const Kinematics& kin) const {
    const MarkerState &P = kin.markers[P_], &Q = kin.markers[Q_];
    const Vector3d r = Q.X_WP.p - P.X_WP.p;
    const double length = r.norm();
    // Ends that coincide leave the direction open; there no force acts.
    const Vector3d e = length > 0.0 ? Vector3d(r / length) : Vector3d(Vector3d::Zero());
    return {e, length, e.dot(Q.V.linear - P.V.linear)};
  }
  double value(const double* signals) const { return value_->evaluate(signals) - load_; }

  int P_, Q_;
  std::shared_ptr<const Expression> value_;
  double load_ = 0.0;  ///< taken away
};

}  // namespace flexura::mbs
