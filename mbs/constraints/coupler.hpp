// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <numbers>

#include "mbs/constraints/constraint.hpp"
#include "mbs/formulas/expression.hpp"
#include "mbs/kinematics/robot_words.hpp"

/// Constraints between joint coordinates.
namespace flexura::mbs {

/// sum_i factor_i q_i = f(t): gears, belts, racks, differentials.
class Coupler final : public Constraint, public HasRobotWords {
 public:
  struct Term {
    CoordinateRef coordinate;
    double factor;
    std::string label;    ///< of what it puts on the coordinate
    CoordinateInfo info;  ///< of the coordinate
  };
  Coupler(std::string name, std::vector<Term> terms, std::shared_ptr<const Expression> value)
      : Constraint(std::move(name)), terms_(std::move(terms)), value_(std::move(value)) {}
  int n_rows() const override { return 1; }
  std::string row_name(int) const override { return "ratio"; }
  bool reads_time(int) const override { return value_.moves(); }
  int n_followed() const override { return value_.follows() ? 1 : 0; }
  Following following(int) const override { return {value_.formula().get(), DriveLevel::position}; }
  void by_followed(const Kinematics&, int, double* g_y, double* h_y, double* h_y_dot) const override {
    g_y[0] = h_y_dot[0] = -1.0;
    h_y[0] = 0.0;
  }
  std::vector<CoordinateRef> coordinates() const override {
    std::vector<CoordinateRef> list;
    for (const Term& term : terms_) list.push_back(term.coordinate);
    return list;
  }

  /// The first coordinate by the second, where there are two and nothing depends on time.
  std::optional<MimicWords> mimic_words() const override {
    if (terms_.size() != 2 || terms_[0].factor == 0.0 || value_.moves()) return std::nullopt;
    const double no_signal = 0.0;
    return MimicWords{.coordinate = terms_[0].coordinate,
                      .of = terms_[1].coordinate,
                      .multiplier = -terms_[1].factor / terms_[0].factor,
                      .offset = value_.formula()->evaluate(&no_signal) / terms_[0].factor};
  }

  void position(const Kinematics& kin, double* g) const override {
    g[0] = -value_.at(kin).value;
    for (const Term& term : terms_) g[0] += term.factor * kin.coordinate(term.coordinate);
    for (const Term& term : terms_)
      if (term.factor != 0.0 && is_without_turns(kin, term.coordinate))
        g[0] = std::remainder(g[0], 2.0 * std::numbers::pi * term.factor);
  }
  void velocity(const Kinematics& kin, double* g_dot) const override {
    g_dot[0] = -value_.at(kin).first;
    for (const Term& term : terms_) g_dot[0] += term.factor * kin.speed(term.coordinate);
  }
  void acceleration(const Kinematics& kin, double* g_ddot) const override {
    g_ddot[0] = -value_.at(kin).second;
    for (const Term& term : terms_) g_ddot[0] += term.factor * kin.acceleration(term.coordinate);
  }
  void apply_GT(const Kinematics&, const double* x, Loads& loads) const override {
    for (const Term& term : terms_) loads.apply(term.coordinate, term.factor * x[0]);
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics&, const double* x, Derivatives& d) const override {
    for (const Term& term : terms_) d.force(term.coordinate, term.factor * x[0]);
    d.rows();
    for (const Term& term : terms_) d.by_speed(term.coordinate, term.factor);
  }
  void rate(const Kinematics& kin, double* g_t) const override { g_t[0] = -value_.at(kin).first; }
  std::vector<OutputInfo> outputs() const override {
    std::vector<OutputInfo> infos;
    for (const Term& term : terms_) {
      const bool turns = term.info.dimension == input::dim::angle;
      infos.push_back({(turns ? "torque_" : "force_") + term.label,
                       turns ? input::dim::torque : input::dim::force,
                       "on the coordinate " + term.info.name});
    }
    return infos;
  }
  void evaluate_outputs(const Kinematics&, const double* x, double* values) const override {
    for (const Term& term : terms_) *values++ = -term.factor * x[0];
  }

 private:
  std::vector<Term> terms_;
  Prescribed value_;
};

}  // namespace flexura::mbs
