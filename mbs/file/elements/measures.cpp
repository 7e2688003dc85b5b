// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/element_types.hpp"
#include "mbs/measures/expression_measure.hpp"
#include "mbs/measures/relative_measure.hpp"

/// Measures in a mechanism file.
namespace flexura::mbs {
namespace {

template <RelativeQuantity (*quantity)()>
MeasureType relative(const char* name, const char* doc) {
  using namespace input;
  MeasureType type;
  type.name = name;
  type.doc = doc;
  type.keys = {text("from", "marker F that it is seen from, \"body.marker\"").required(),
               text("to", "marker M that it is taken of").required()};
  if (quantity().has_direction)
    type.keys.push_back(vector3("direction", dim::none, "in the axes of F").required());
  type.read = [](const std::string& own, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Measure> {
    Vector3d e = Vector3d::Zero();
    if (quantity().has_direction) {
      e = s.vector3("direction");
      if (!(e.norm() > 0.0)) s.refuse("direction", "has no length", "write for example [1, 0, 0]");
      e.normalize();
    }
    return std::make_shared<RelativeMeasure>(own, c.marker(s, "from"), c.marker(s, "to"), quantity(), e);
  };
  return type;
}

MeasureType expression() {
  return {"expression",
          "A formula of t, parameters, joint coordinates and the measures above it.",
          {input::expression("value", "the formula, in SI").required(),
           input::text("unit",
                       "of its value, in tables and plots: an SI unit as in \"N\", \"rad/s\"; without it a "
                       "plain number")},
          [](const std::string& name, const input::Section& s,
             const ReadContext& context) -> std::shared_ptr<const Measure> {
            input::Dimension dimension = input::dim::none;
            if (s.has("unit")) {
              try {
                const input::Measured unit = input::parse_unit(s.text("unit"));
                if (unit.value != 1.0)
                  s.refuse("unit", "is no SI unit",
                           "formulas are computed in SI; write \"" + input::si_unit(unit.dimension) + "\"");
                dimension = unit.dimension;
              } catch (const input::InputError&) {
                throw;
              } catch (const std::invalid_argument& failure) {
                s.refuse("unit", failure.what(), "write an SI unit, as in \"N\" or \"rad/s\"");
              }
            }
            return std::make_shared<ExpressionMeasure>(name, context.expression(s, "value"), dimension);
          }};
}

}  // namespace

const std::vector<MeasureType>& measure_types() {
  static const std::vector<MeasureType> types = {
      relative<RelativeQuantity::distance>("distance", "Distance of two markers."),
      relative<RelativeQuantity::distance_rate>("distance_rate",
                                                "Time derivative of the distance of two markers."),
      relative<RelativeQuantity::position>("position", "Component of the position of M in F."),
      relative<RelativeQuantity::axis>("axis", "Component of the z axis of M in F, a direction cosine."),
      relative<RelativeQuantity::velocity>("velocity", "Component of the velocity of M as seen from F."),
      relative<RelativeQuantity::angle>("angle", "Angle of M about the z axis of F, within +-180 deg."),
      relative<RelativeQuantity::angular_velocity>("angular_velocity",
                                                   "Component of the angular velocity of M as seen from F."),
      expression()};
  return types;
}

}  // namespace flexura::mbs
