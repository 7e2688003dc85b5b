// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/read_expression_constraint.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mbs/constraints/expression_constraint.hpp"
#include "mbs/formulas/operations.hpp"

namespace flexura::mbs {
namespace {

/// Finds what a formula depends on, through the measures that are formulas themselves.
class Arguments {
 public:
  Arguments(const input::Section& s, const ReadContext& c) : s_(s), c_(c), d_(c.description()) {}

  void take(const Expression& f) {
    const auto jumps = [](const FormulaNode& node) {
      return operations::jumps(node.code) || node.code == operations::equal ||
             node.code == operations::not_equal;
    };
    if (f.tree().any(f.tree().root, jumps))
      s_.refuse("value", "holds a comparison, a sign or a rounding, where it may jump, and no position can",
                "write it smooth: with step(x, x_0, y_0, x_1, y_1) or a table");
    for (const int place : f.reads())
      if (std::ranges::find(known_, place) == known_.end()) take(place);
  }

  std::vector<ExpressionConstraint::Argument> arguments;
  std::vector<ExpressionConstraint::Between> between;

 private:
  void take(int place) {
    known_.push_back(place);
    const std::string& name = d_.signals.names()[static_cast<std::size_t>(place)];
    if (take_coordinate(place, name)) return;
    for (const auto& measure : d_.measures) {
      if (!measure || measure->name() != name) continue;
      if (const std::shared_ptr<const Expression> formula = c_.formula_of(*measure)) {
        take(*formula);
        between.push_back({place, formula});
        return;
      }
      const auto [F, M] = measure->markers_of_pose();
      if (F < 0) cannot_read(name, "no measure of a position, distance or angle");
      arguments.push_back(
          {place, {}, F, M, [measure](const Relative& rel) { return measure->of_pose(rel); }});
      return;
    }
    const auto has_name = [&](const auto& one) { return one.name == name; };
    const auto is_called = [&](const auto& control) { return control->name() == name; };
    if (!std::ranges::any_of(d_.inputs, has_name) && !std::ranges::any_of(d_.controls, is_called))
      cannot_read(name, "a reaction, an acceleration or a control that passes on what it reads");
    arguments.push_back(
        {place, {}, -1, -1, {}, c_.motion_expression_of(s_, "value", name.substr(c_.prefix().size()))});
  }

  bool take_coordinate(int place, const std::string& name) {
    for (std::size_t j = 0; j < d_.joints.size(); ++j) {
      const JointDescription& joint = d_.joints[j];
      if (!name.starts_with(joint.name + ".")) continue;
      const std::string own = name.substr(joint.name.size() + 1);
      const auto is_own = [&](const CoordinateInfo& info) { return info.name == own; };
      if (std::ranges::any_of(joint.joint->speeds(), is_own)) cannot_read(name, "a speed");
      const auto coordinates = joint.joint->coordinates();
      const auto found = std::ranges::find_if(coordinates, is_own);
      if (found == coordinates.end()) continue;
      if (joint.joint->n_p() != joint.joint->n_v())
        cannot_read(
            name, fmt::format("a coordinate of a {} joint, whose rates are no speeds", joint.joint->type()));
      arguments.push_back(
          {place, {static_cast<int>(j), static_cast<int>(found - coordinates.begin())}, -1, -1, {}});
      return true;
    }
    return false;
  }

  [[noreturn]] void cannot_read(const std::string& name, const std::string& what) const {
    s_.refuse("value", fmt::format("reads \"{}\", {}", name.substr(c_.prefix().size()), what),
              "let it read t, parameters, inputs, states of controls, joint coordinates, measures of "
              "position, distance, "
              "axis, angle or rotation_angle, and measures that are formulas of these");
  }

  const input::Section& s_;
  const ReadContext& c_;
  const MechanismDescription& d_;
  std::vector<int> known_;
};

std::shared_ptr<const Constraint> read(const std::string& name, const input::Section& s,
                                       const ReadContext& c) {
  const auto value = c.plain_expression(s, "value");
  Arguments found(s, c);
  found.take(*value);
  if (std::ranges::all_of(found.arguments, [](const auto& y) { return y.followed != nullptr; }))
    s.refuse("value", "reads no coordinate: there is nothing that it could hold",
             "write a formula of joint coordinates or of measures of positions");
  return std::make_shared<ExpressionConstraint>(name, std::move(found.arguments), std::move(found.between),
                                                value, c.description().signals.size(), read_unit(s));
}

}  // namespace

ConstraintType expression_constraint() {
  using namespace input;
  return {
      "expression",
      "A formula of the motion vanishes: any surface, curve or gearing that joint coordinates or positions "
      "of markers are held to, as a cam, a wheel on a rail, a mechanism's law. It must be smooth to its "
      "second derivatives where the motion passes: comparisons, sign and what rounds are refused.",
      {expression("value",
                  "what is held at 0: a formula of t, parameters, joint coordinates, measures of "
                  "position, distance, axis, angle or rotation_angle, inputs, states of controls, algebraic "
                  "states of these, and measures that are formulas of all these, in SI")
           .required(),
       unit_key("the value")},
      {{"force", "N or N*m",
        "generalised force along the value (of a length, an angle): on a coordinate it puts this times the "
        "value's derivative by it"}},
      read};
}

}  // namespace flexura::mbs
