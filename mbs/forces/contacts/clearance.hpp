// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "mbs/forces/contacts/contact_law.hpp"
#include "mbs/forces/force.hpp"
#include "mbs/kinematics/robot_words.hpp"

/// Two-sided contacts along one scalar x = sum of factor * coordinate: x may move freely between `lower` and
/// `upper` and meets a contact law (contact_law.hpp) beyond either.
namespace flexura::mbs {

class Clearance final : public ForceElement, public HasRobotWords {
 public:
  struct Term {
    CoordinateRef coordinate;
    double factor;
  };
  /// The stiffness of teeth in mesh: 1 + amplitude cos(count q), q the first coordinate.
  struct Ripple {
    double amplitude = 0.0, count = 0.0;
  };
  Clearance(std::string name, std::string_view type, std::vector<Term> terms, double lower, double upper,
            ContactLaw law, Ripple ripple, input::Dimension measured_in, input::Dimension pushes_in)
      : ForceElement(std::move(name)),
        type_(type),
        terms_(std::move(terms)),
        lower_(lower),
        upper_(upper),
        law_(law),
        ripple_(ripple),
        measured_in_(measured_in),
        pushes_in_(pushes_in) {}
  std::string_view type() const override { return type_; }
  ForceNature nature() const override { return ForceNature::response; }
  std::vector<CoordinateRef> coordinates() const override {
    std::vector<CoordinateRef> all;
    for (const Term& term : terms_) all.push_back(term.coordinate);
    return all;
  }
  /// The ends of one coordinate's travel.
  std::optional<JointWords> joint_words() const override {
    if (terms_.size() != 1 || terms_[0].factor != 1.0 || ripple_.amplitude != 0.0) return std::nullopt;
    return JointWords{
        .coordinate = terms_[0].coordinate, .lower = lower_, .upper = upper_, .stiffness = law_.stiffness()};
  }
  int n_states() const override { return 2 * law_.n_states(); }
  bool is_held(int) const override { return true; }
  int n_switches() const override { return 2 * ContactLaw::n_switches; }
  std::string switch_name(int i) const override {
    static const char* names[] = {"lower_gap", "lower_push", "upper_gap", "upper_push"};
    return names[i];
  }
  bool jumps_at(int which) const override { return ContactLaw::jumps_at(which % ContactLaw::n_switches); }
  void start(double* c) const override { std::fill_n(c, n_states(), 1.0); }
  void rates(const Kinematics&, const double*, double* c_rate) const override {
    std::fill_n(c_rate, n_states(), 0.0);
  }
  void switching(const Kinematics& kin, const double*, double* values) const override {
    for (int side = 0; side < 2; ++side) {
      const auto [gap, rate] = gap_of(side, kin);
      law_.switching(gap, rate, kin.own.root + 2 * side, kin.own.c + side, values + 2 * side);
    }
  }
  void start_switches(const Kinematics& kin, const double*, int* root, double* c) const override {
    for (int side = 0; side < 2; ++side) {
      const auto [gap, rate] = gap_of(side, kin);
      law_.start(gap, rate, root + 2 * side, c + side);
    }
  }
  void change_switch(int which, const Kinematics& kin, const double*, int* root, double* c) const override {
    const int side = which / 2;
    law_.change(which % 2, gap_of(side, kin).second, root + 2 * side, c + side);
  }

  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    const double f = force(kin);
    for (const Term& term : terms_) loads.apply(term.coordinate, term.factor * f);
    // The stored energy changes with the stiffness, too: the force is its gradient.
    if (ripple_.amplitude != 0.0) {
      const double q = kin.coordinate(terms_[0].coordinate);
      loads.apply(terms_[0].coordinate,
                  ripple_.amplitude * ripple_.count * std::sin(ripple_.count * q) * unscaled_energy(kin));
    }
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    // f = scale F; F = N below - N above.
    double F = 0.0, energy_slope = 0.0;
    ContactLaw::Slopes at[2];
    for (int side = 0; side < 2; ++side) {
      const auto [gap, rate] = gap_of(side, kin);
      const int* root = kin.own.root + 2 * side;
      const double sign = side == 0 ? 1.0 : -1.0;
      at[side] = law_.slopes(gap, rate, root, kin.own.c + side);
      F += sign * law_.force(gap, rate, root, kin.own.c + side);
      energy_slope -= sign * law_.elastic_force(gap, root);
    }
    const CoordinateRef first = terms_[0].coordinate;
    const double q = ripple_.amplitude == 0.0 ? 0.0 : kin.coordinate(first), n = ripple_.count;
    const double f = scale(kin), scale_slope = -ripple_.amplitude * n * std::sin(n * q);
    for (const Term& term : terms_) {
      d.force(term.coordinate, term.factor * f * F);
      for (const Term& other : terms_) {
        const double factor = term.factor * other.factor * f;
        d.by_coordinate(other.coordinate, factor * (at[0].by_gap + at[1].by_gap));
        d.by_speed(other.coordinate, factor * (at[0].by_rate + at[1].by_rate));
      }
      if (ripple_.amplitude != 0.0) d.by_coordinate(first, term.factor * scale_slope * F);
      if (law_.n_states() > 0)
        for (int side = 0; side < 2; ++side)
          d.by_state(side, (side == 0 ? 1.0 : -1.0) * term.factor * f * at[side].by_state);
    }
    if (ripple_.amplitude == 0.0) return;
    d.force(first, -scale_slope * unscaled_energy(kin));
    d.by_coordinate(first, ripple_.amplitude * n * n * std::cos(n * q) * unscaled_energy(kin));
    for (const Term& term : terms_)
      d.by_coordinate(term.coordinate, -scale_slope * energy_slope * term.factor);
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    powers.potential += scale(kin) * unscaled_energy(kin);
    for (int side = 0; side < 2; ++side) {
      const auto [gap, rate] = gap_of(side, kin);
      powers.dissipated += scale(kin) * law_.lost_power(gap, rate, kin.own.root + 2 * side, kin.own.c + side);
    }
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"position", measured_in_, "between the two sides"},
            {"force", pushes_in_, "along it, positive away from the lower side"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    values[0] = 0.0;
    for (const Term& term : terms_) values[0] += term.factor * kin.coordinate(term.coordinate);
    values[1] = force(kin);
  }

 private:
  /// Side 0 is the lower one.
  std::pair<double, double> gap_of(int side, const Kinematics& kin) const {
    double x = 0.0, v = 0.0;
    for (const Term& term : terms_) {
      x += term.factor * kin.coordinate(term.coordinate);
      v += term.factor * kin.speed(term.coordinate);
    }
    return side == 0 ? std::pair(x - lower_, v) : std::pair(upper_ - x, -v);
  }
  double scale(const Kinematics& kin) const {
    if (ripple_.amplitude == 0.0) return 1.0;
    return 1.0 + ripple_.amplitude * std::cos(ripple_.count * kin.coordinate(terms_[0].coordinate));
  }
  double unscaled_energy(const Kinematics& kin) const {
    return law_.energy(gap_of(0, kin).first, kin.own.root) +
           law_.energy(gap_of(1, kin).first, kin.own.root + 2);
  }
  double force(const Kinematics& kin) const {
    double f = 0.0;
    for (int side = 0; side < 2; ++side) {
      const auto [gap, rate] = gap_of(side, kin);
      f += (side == 0 ? 1.0 : -1.0) *
           law_.force(gap, rate, kin.own.root + 2 * side, kin.own.c ? kin.own.c + side : nullptr);
    }
    return scale(kin) * f;
  }

  std::string_view type_;
  std::vector<Term> terms_;
  double lower_, upper_;
  ContactLaw law_;
  Ripple ripple_;
  input::Dimension measured_in_, pushes_in_;
};

}  // namespace flexura::mbs
