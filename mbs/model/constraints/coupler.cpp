// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "mbs/model/constraints/types.hpp"

/// Constraints between joint coordinates.
namespace flexura::mbs {
namespace {

/// sum_i factor_i q_i = f(t): gears, belts, racks, differentials.
class Coupler final : public Constraint {
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
  bool reads_time(int) const override { return value_->reads_time(); }
  std::vector<CoordinateRef> coordinates() const override {
    std::vector<CoordinateRef> list;
    for (const Term& term : terms_) list.push_back(term.coordinate);
    return list;
  }

  void position(const Kinematics& kin, double* g) const override {
    g[0] = -value_->time_derivatives(kin.t).value;
    for (const Term& term : terms_) g[0] += term.factor * kin.coordinate(term.coordinate);
  }
  void velocity(const Kinematics& kin, double* g_dot) const override {
    g_dot[0] = -value_->time_derivatives(kin.t).first;
    for (const Term& term : terms_) g_dot[0] += term.factor * kin.speed(term.coordinate);
  }
  void acceleration(const Kinematics& kin, double* g_ddot) const override {
    g_ddot[0] = -value_->time_derivatives(kin.t).second;
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
  void rate(const Kinematics& kin, double* g_t) const override {
    g_t[0] = -value_->time_derivatives(kin.t).first;
  }
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
  std::shared_ptr<const Expression> value_;
};

using input::Section;

Coupler::Term term(const ReadContext& c, CoordinateRef coordinate, double factor, std::string label) {
  return {coordinate, factor, std::move(label), c.coordinate_info(coordinate)};
}

input::Key offset() {
  return input::expression("offset", "value of the sum: a formula of t and parameters").or_default("0");
}

}  // namespace

ConstraintType coupler_constraint() {
  using namespace input;
  return {
      "coupler",
      "A weighted sum of joint coordinates has a value: sum of factors[i] * (coordinate of joints[i]) = "
      "offset.",
      {texts("joints", "joints with one coordinate, or \"joint.coordinate\"").required(),
       quantities("factors", dim::none, "one for each, in SI units of the coordinates").required(), offset()},
      [](const std::string& name, const Section& s,
         const ReadContext& c) -> std::shared_ptr<const Constraint> {
        const std::vector<std::string> joints = s.texts("joints");
        const std::vector<double> factors = s.quantities("factors");
        if (joints.size() != factors.size() || joints.empty())
          s.refuse("factors", "does not have one entry for each of joints");
        std::vector<Coupler::Term> terms;
        for (std::size_t i = 0; i < joints.size(); ++i)
          terms.push_back(term(c, c.coordinate(s, "joints", joints[i]), factors[i], std::to_string(i + 1)));
        return std::make_shared<Coupler>(name, std::move(terms), c.time_expression(s, "offset"));
      }};
}

ConstraintType gear_constraint() {
  using namespace input;
  return {"gear",
          "Two toothed wheels in mesh: teeth_1 q_1 + teeth_2 q_2 = teeth_1 * offset; internal gears turn the "
          "same way. Their joints must sit on one carrier (ground or a planet carrier).",
          {text("joint_1", "joint of the first wheel, or \"joint.coordinate\"").required(),
           text("joint_2", "joint of the second wheel").required(),
           quantity("teeth_1", dim::none, "number of teeth, or pitch radius").required().above(0.0),
           quantity("teeth_2", dim::none, "number of teeth, or pitch radius, of the second")
               .required()
               .above(0.0),
           flag("internal", "one of the wheels has its teeth inside").or_default("false"), offset()},
          [](const std::string& name, const Section& s,
             const ReadContext& c) -> std::shared_ptr<const Constraint> {
            const double ratio =
                s.quantity("teeth_2") / s.quantity("teeth_1") * (s.flag("internal") ? -1.0 : 1.0);
            std::vector<Coupler::Term> terms{
                term(c, c.coordinate(s, "joint_1", s.text("joint_1")), 1.0, "1"),
                term(c, c.coordinate(s, "joint_2", s.text("joint_2")), ratio, "2")};
            return std::make_shared<Coupler>(name, std::move(terms), c.time_expression(s, "offset"));
          }};
}

ConstraintType rack_and_pinion_constraint() {
  using namespace input;
  return {"rack_and_pinion",
          "A rack driven by a pinion: position - radius * angle = offset; a negative radius turns the sense "
          "round.",
          {text("rack", "joint of the rack, or \"joint.coordinate\"").required(),
           text("pinion", "joint of the pinion").required(),
           quantity("radius", dim::length, "pitch radius of the pinion").required(), offset()},
          [](const std::string& name, const Section& s,
             const ReadContext& c) -> std::shared_ptr<const Constraint> {
            std::vector<Coupler::Term> terms{
                term(c, c.coordinate(s, "rack", s.text("rack")), 1.0, "rack"),
                term(c, c.coordinate(s, "pinion", s.text("pinion")), -s.quantity("radius"), "pinion")};
            return std::make_shared<Coupler>(name, std::move(terms), c.time_expression(s, "offset"));
          }};
}

}  // namespace flexura::mbs
