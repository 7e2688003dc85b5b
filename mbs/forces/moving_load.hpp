// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "mbs/forces/force.hpp"
#include "mbs/formulas/expression.hpp"
#include "mbs/kinematics/body_path.hpp"
#include "mbs/kinematics/picture.hpp"

namespace flexura::mbs {

/// A given force f on the particle of a path (body_path.hpp) at the place s, both by formulas; beyond the path's ends
/// there is none: switches, so that no step leaps over a load that comes and goes.  It is shared among the path's markers, f_j = b_j(s) f, so that its power is f . r_t(s), with r_t the
/// velocity of the particle that it acts on.
class MovingLoad final : public ForceElement, public HasPicture {
 public:
  using Components = std::array<std::shared_ptr<const Expression>, 3>;
  MovingLoad(std::string name, std::shared_ptr<const BodyPath> path, std::shared_ptr<const Expression> place,
             int axes, Components components)
      : ForceElement(std::move(name)),
        path_(std::move(path)),
        place_(std::move(place)),
        axes_(axes),
        components_(std::move(components)) {}
  std::string_view type() const override { return "moving_load"; }
  std::pair<int, int> markers() const override { return {-1, path_->marker(0)}; }
  int axes() const override { return axes_; }
  const BodyPath* drawn_path() const override { return path_.get(); }
  std::vector<int> reads() const override {
    std::vector<int> reads = place_->reads();
    for (const auto& f : components_)
      if (f) reads.insert(reads.end(), f->reads().begin(), f->reads().end());
    return reads;
  }
  ForceNature nature() const override { return ForceNature::load; }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double* signals) const override {
    auto rest = std::make_shared<MovingLoad>(*this);
    rest->load_ = components(signals) + load_;
    return rest;
  }

  int n_switches() const override { return kEnds; }
  std::string switch_name(int i) const override { return i == kBegin ? "begin" : "end"; }
  void switching(const Kinematics& kin, const double* signals, double* values) const override {
    const double s = place_->evaluate(signals);
    values[kBegin] = kin.own.root[kBegin] != 0 ? s : -s;
    values[kEnd] = kin.own.root[kEnd] != 0 ? path_->length() - s : s - path_->length();
  }
  void start_switches(const Kinematics&, const double* signals, int* root, double*) const override {
    const double s = place_->evaluate(signals);
    root[kBegin] = s > 0.0 || path_->holds(s) ? 1 : 0;
    root[kEnd] = s < path_->length() || path_->holds(s) ? 1 : 0;
  }
  void change_switch(int which, const Kinematics&, const double*, int* root, double*) const override {
    root[which] = 1 - root[which];
  }

  void apply(const Kinematics& kin, const double* signals, Loads& loads) const override {
    if (!is_on(kin)) return;
    const double s = place_->evaluate(signals);
    const BodyPath::Weights w = path_->weights(s);
    const Vector3d f = force(kin, signals);
    for (int k = 0; k < w.n; ++k)
      loads.apply(path_->marker(w.first + k), Spatial{Vector3d::Zero(), w.b(0, k) * f});
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* signals, Derivatives& d) const override {
    if (!is_on(kin)) return;
    const double s = place_->evaluate(signals);
    const BodyPath::Weights w = path_->weights(s);
    Vector6d wrench = Vector6d::Zero();
    wrench.tail<3>() = components(signals);
    for (int k = 0; k < w.n; ++k) {
      d.wrench(path_->marker(w.first + k), axes_, -1, w.b(0, k) * wrench);
      d.by_formula(*place_, signals, w.b(1, k) * wrench);
      for (int i = 0; i < 3; ++i)
        if (components_[i]) d.by_formula(*components_[i], signals, w.b(0, k) * Vector6d::Unit(3 + i));
    }
  }
  void add_powers(const Kinematics& kin, const double* signals, Powers& powers) const override {
    if (!is_on(kin)) return;
    const BodyPath::Weights w = path_->weights(place_->evaluate(signals));
    Vector3d v = Vector3d::Zero();
    for (int k = 0; k < w.n; ++k) v += w.b(0, k) * kin.markers[path_->marker(w.first + k)].V.linear;
    powers.input += force(kin, signals).dot(v);
  }
  std::vector<OutputInfo> outputs() const override {
    const auto d = input::dim::force;
    return {{"place", input::dim::length, "where along the path, by the undeformed body"},
            {"x", d, "component in its axes; 0 beyond the path"},
            {"y", d, "component in its axes"},
            {"z", d, "component in its axes"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double* signals, double* values) const override {
    values[0] = place_->evaluate(signals);
    Eigen::Map<Vector3d> out(values + 1);
    out.setZero();
    if (is_on(kin)) out = components(signals);
  }

 private:
  // Switches: 1 where the place is on the path's side of this end.
  enum : int { kBegin, kEnd, kEnds };
  static bool is_on(const Kinematics& kin) { return kin.own.root[kBegin] != 0 && kin.own.root[kEnd] != 0; }
  Vector3d components(const double* signals) const {
    Vector3d f;
    for (int i = 0; i < 3; ++i) f(i) = components_[i] ? components_[i]->evaluate(signals) : 0.0;
    return f - load_;
  }
  Vector3d force(const Kinematics& kin, const double* signals) const {
    const Vector3d f = components(signals);
    return axes_ >= 0 ? Vector3d(kin.markers[axes_].X_WP.R * f) : f;
  }

  std::shared_ptr<const BodyPath> path_;
  std::shared_ptr<const Expression> place_;
  int axes_;
  Components components_;
  Vector3d load_ = Vector3d::Zero();  ///< taken away
};

}  // namespace flexura::mbs
