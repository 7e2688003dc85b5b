// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "mbs/model/contact_law.hpp"
#include "mbs/model/forces/types.hpp"

/// Two-sided contacts along one scalar x = sum of factor * coordinate: x may move freely between `lower` and
/// `upper` and meets a contact law (contact_law.hpp) beyond either.
namespace flexura::mbs {
namespace {

class Clearance final : public ForceElement {
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
  int n_states() const override { return 2 * law_.n_states(); }
  int n_switches() const override { return 2 * ContactLaw::n_switches; }
  std::string switch_name(int i) const override {
    static const char* names[] = {"lower_gap", "lower_push", "upper_gap", "upper_push"};
    return names[i];
  }
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
      f += (side == 0 ? 1.0 : -1.0) * law_.force(gap, rate, kin.own.root + 2 * side, kin.own.c + side);
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

/// Far enough to be no limit, near enough for differences.
constexpr double nowhere = 1e12;

}  // namespace

ForceType bump_stop_force() {
  using namespace input;
  std::vector<Key> keys = {
      text("joint", "the joint").required(),
      text("coordinate", "its coordinate, where it has more than one: \"angle\", \"position\", ..."),
      expression("lower", "least coordinate that moves freely (m or rad); without it no limit"),
      expression("upper", "greatest coordinate that moves freely; without it no limit")};
  for (Key& key : contact_law_keys()) keys.push_back(std::move(key));
  return {"bump_stop", "Elastic ends of a joint's travel, touched and left at switches.", std::move(keys),
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            if (!s.has("lower") && !s.has("upper"))
              s.refuse("", "has neither lower nor upper", "give at least one");
            const double lower = s.has("lower") ? context.number(s, "lower") : -nowhere;
            const double upper = s.has("upper") ? context.number(s, "upper") : nowhere;
            if (!(lower < upper)) s.refuse("lower", "is not below upper");
            return std::make_shared<Clearance>(
                name, "bump_stop",
                std::vector<Clearance::Term>{{context.speed(s, "joint", "coordinate"), 1.0}}, lower, upper,
                read_contact_law(s, context), Clearance::Ripple{}, dim::none, dim::none);
          }};
}

ForceType gear_mesh_force() {
  using namespace input;
  std::vector<Key> keys = {
      text("joint_1", "joint of the first wheel, or \"joint.coordinate\"").required(),
      text("joint_2", "joint of the second wheel, on the same carrier").required(),
      quantity("radius_1", dim::length, "base radius of the first wheel; for a rack's joint write 1")
          .required()
          .above(0.0),
      quantity("radius_2", dim::length, "base radius of the second wheel").required().above(0.0),
      flag("internal", "one of the wheels has its teeth inside").or_default("false"),
      quantity("backlash", dim::length, "play along the line of action").or_default("0 m").at_least(0.0),
      quantity("teeth_1", dim::none, "teeth of the first wheel, for the stiffness' ripple").at_least(1.0),
      quantity("ripple", dim::none, "part by which the stiffness changes as teeth come and go")
          .or_default("0")
          .at_least(0.0)
          .below(1.0)};
  for (Key& key : contact_law_keys()) keys.push_back(std::move(key));
  return {
      "gear_mesh",
      "Teeth of two wheels in mesh with backlash and tooth stiffness: they touch on either flank and part at "
      "switches. x = radius_1 q_1 + radius_2 q_2 is free within half the backlash on both sides.",
      std::move(keys),
      [](const std::string& name, const Section& s,
         const ReadContext& context) -> std::shared_ptr<const ForceElement> {
        Clearance::Ripple ripple{s.quantity("ripple"), 0.0};
        if (ripple.amplitude > 0.0 && !s.has("teeth_1"))
          s.refuse("ripple", "needs teeth_1", "say how often it comes");
        if (s.has("teeth_1")) ripple.count = s.quantity("teeth_1");
        const double half = 0.5 * s.quantity("backlash"), sign = s.flag("internal") ? -1.0 : 1.0;
        return std::make_shared<Clearance>(
            name, "gear_mesh",
            std::vector<Clearance::Term>{
                {context.coordinate(s, "joint_1", s.text("joint_1")), s.quantity("radius_1")},
                {context.coordinate(s, "joint_2", s.text("joint_2")), sign * s.quantity("radius_2")}},
            -half, half, read_contact_law(s, context), ripple, dim::length, dim::force);
      }};
}

}  // namespace flexura::mbs
