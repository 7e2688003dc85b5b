// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "mbs/forces/force.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// A force or torque at a marker, its three components by formulas in the axes of a frame; its reaction, if
/// wanted, acts on another body at the same point.
class Applied final : public ForceElement {
 public:
  using Components = std::array<std::shared_ptr<const Expression>, 3>;
  Applied(std::string name, bool is_torque, int marker, int axes, int reaction, Components components)
      : ForceElement(std::move(name)),
        is_torque_(is_torque),
        marker_(marker),
        axes_(axes),
        reaction_(reaction),
        components_(std::move(components)) {}
  std::string_view type() const override { return is_torque_ ? "torque" : "force"; }
  std::pair<int, int> markers() const override { return {reaction_, marker_}; }
  int axes() const override { return axes_; }
  std::vector<int> reads() const override {
    std::vector<int> reads;
    for (const auto& f : components_)
      if (f) reads.insert(reads.end(), f->reads().begin(), f->reads().end());
    return reads;
  }
  ForceNature nature() const override { return ForceNature::load; }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double* signals) const override {
    auto rest = std::make_shared<Applied>(*this);
    rest->load_ = components(signals) + load_;
    return rest;
  }

  void apply(const Kinematics& kin, const double* signals, Loads& loads) const override {
    const Spatial w = wrench(kin, signals);
    loads.apply(marker_, w);
    if (reaction_ >= 0) loads.apply(reaction_, at_reaction(kin, w));
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics&, const double* signals, Derivatives& d) const override {
    Vector6d wrench = Vector6d::Zero();
    const int first = is_torque_ ? 0 : 3;
    wrench.segment<3>(first) = components(signals);
    d.wrench(marker_, axes_, reaction_, wrench);
    for (int i = 0; i < 3; ++i)
      if (components_[i]) d.by_formula(*components_[i], signals, Vector6d::Unit(first + i));
  }
  void add_powers(const Kinematics& kin, const double* signals, Powers& powers) const override {
    const Spatial w = wrench(kin, signals);
    powers.input += w.dot(kin.markers[marker_].V);
    if (reaction_ >= 0) powers.input += at_reaction(kin, w).dot(kin.markers[reaction_].V);
  }
  std::vector<OutputInfo> outputs() const override {
    const auto d = is_torque_ ? input::dim::torque : input::dim::force;
    return {{"x", d, "component in its axes"},
            {"y", d, "component in its axes"},
            {"z", d, "component in its axes"}};
  }
  void evaluate_outputs(const Kinematics&, const double* signals, double* values) const override {
    Eigen::Map<Vector3d> out(values);
    out = components(signals);
  }

 private:
  Vector3d components(const double* signals) const {
    Vector3d f;
    for (int i = 0; i < 3; ++i) f(i) = components_[i] ? components_[i]->evaluate(signals) : 0.0;
    return f - load_;
  }
  Spatial wrench(const Kinematics& kin, const double* signals) const {
    Vector3d f = components(signals);
    if (axes_ >= 0) f = kin.markers[axes_].X_WP.R * f;
    return is_torque_ ? Spatial{f, Vector3d::Zero()} : Spatial{Vector3d::Zero(), f};
  }
  Spatial at_reaction(const Kinematics& kin, const Spatial& w) const {
    const Spatial moved = shift_wrench(w, kin.markers[marker_].X_WP.p - kin.markers[reaction_].X_WP.p);
    return {-moved.angular, -moved.linear};
  }

  bool is_torque_;
  int marker_, axes_, reaction_;
  Components components_;
  Vector3d load_ = Vector3d::Zero();  ///< taken away
};

}  // namespace flexura::mbs
