// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include "mbs/forces/force.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// A load case of a body's superelement times a formula (body_load.hpp).
class DistributedLoad final : public ForceElement {
 public:
  DistributedLoad(std::string name, int body, int load, int frame, std::shared_ptr<const Expression> factor)
      : ForceElement(std::move(name)), body_(body), load_(load), frame_(frame), factor_(std::move(factor)) {}
  std::string_view type() const override { return "distributed_load"; }
  std::pair<int, int> markers() const override { return {-1, frame_}; }
  std::pair<int, int> load_case() const override { return {body_, load_}; }
  std::vector<int> reads() const override { return factor_->reads(); }
  ForceNature nature() const override { return ForceNature::load; }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double* signals) const override {
    auto rest = std::make_shared<DistributedLoad>(*this);
    rest->taken_away_ = factor_->evaluate(signals);
    return rest;
  }

  void apply(const Kinematics& kin, const double* signals, Loads& loads) const override {
    const BodyLoad& load = of(kin);
    const double factor = this->factor(signals);
    const Vector6d wrench = factor * load.wrench_at(kin.bodies[body_].s).vector();
    loads.apply(frame_, kin.markers[frame_].X_WP.R * Spatial::from(wrench));
    if (load.modal.size() > 0) loads.apply_modal(body_, load.modal, factor);
    if (const Eigen::VectorXd more = load.stiffening_at(kin.bodies[body_].s); more.size() > 0)
      loads.apply_modal(body_, more, factor);
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* signals, Derivatives& d) const override {
    const BodyLoad& load = of(kin);
    const double factor = this->factor(signals);
    const double* s = kin.bodies[body_].s;
    const Vector6d wrench = load.wrench_at(s).vector();
    d.wrench(frame_, frame_, -1, factor * wrench);
    d.by_formula(*factor_, signals, wrench);
    for (int i = 0; s && i < load.moment.cols(); ++i)
      d.by_deformation(body_, i, factor * Spatial{load.moment.col(i), Vector3d::Zero()}.vector());
    if (!s) return;
    if (load.K0.size() == 0) {
      d.modal(body_, load.modal);
      d.by_formula(*factor_, signals);
      return;
    }
    d.modal(body_, load.modal + load.stiffening_at(s));
    d.by_formula(*factor_, signals);
    for (Eigen::Index i = 0; factor != 0.0 && i < load.K0.cols(); ++i) {
      d.modal(body_, load.K0.col(i));
      d.by_deformation(body_, static_cast<int>(i), -factor * Vector6d::Unit(0));
    }
  }
  void add_powers(const Kinematics& kin, const double* signals, Powers& powers) const override {
    const BodyLoad& load = of(kin);
    const BodyState& body = kin.bodies[body_];
    const MarkerState& frame = kin.markers[frame_];
    double power = (frame.X_WP.R * load.wrench_at(body.s)).dot(frame.V);
    if (body.s_dot) {
      const Eigen::Map<const Eigen::VectorXd> s_dot(body.s_dot, load.modal.size());
      power += load.modal.dot(s_dot);
      if (load.K0.size() > 0) power += load.stiffening_at(body.s).dot(s_dot);
    }
    powers.input += factor(signals) * power;
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"factor", input::dim::none, "factor of the load case"}};
  }
  void evaluate_outputs(const Kinematics&, const double* signals, double* values) const override {
    values[0] = factor(signals);
  }

 private:
  double factor(const double* signals) const { return factor_->evaluate(signals) - taken_away_; }
  const BodyLoad& of(const Kinematics& kin) const {
    return (*kin.bodies[body_].loads)[static_cast<std::size_t>(load_)];
  }

  int body_, load_, frame_;
  std::shared_ptr<const Expression> factor_;
  double taken_away_ = 0.0;
};

}  // namespace flexura::mbs
