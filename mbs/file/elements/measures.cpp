// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/math/rotation_sequences.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "mbs/file/elements/read_reaction.hpp"
#include "mbs/file/elements/user_library.hpp"
#include "mbs/measures/acceleration.hpp"
#include "mbs/measures/expression_measure.hpp"
#include "mbs/measures/load_cell.hpp"
#include "mbs/measures/relative_measure.hpp"
#include "mbs/measures/rotation_angle.hpp"
#include "mbs/measures/surface_distance.hpp"

/// Measures in a mechanism file.
namespace flexura::mbs {
namespace {

Vector3d read_direction(const input::Section& s) {
  const Vector3d e = s.vector3("direction");
  if (!(e.norm() > 0.0)) s.refuse("direction", "has no length", "write for example [1, 0, 0]");
  return e.normalized();
}

template <RelativeQuantity (*quantity)()>
MeasureType relative(const char* name, const char* doc) {
  using namespace input;
  MeasureType type;
  type.name = name;
  type.doc = doc;
  type.gives = {{"", input::si_unit(quantity().dimension), ""}};
  type.keys = {text("from", "marker F that it is seen from, \"body.marker\"").required(),
               text("to", "marker M that it is taken of").required()};
  if (quantity().has_direction)
    type.keys.push_back(vector3("direction", dim::none, "in the axes of F").required());
  type.read = [](const std::string& own, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Measure> {
    Vector3d e = Vector3d::Zero();
    if (quantity().has_direction) e = read_direction(s);
    return std::make_shared<RelativeMeasure>(own, c.marker(s, "from"), c.marker(s, "to"), quantity(), e);
  };
  return type;
}

MeasureType rotation_angle() {
  using namespace input;
  return {
      "rotation_angle",
      "One of the Cardan (Tait-Bryan) or Euler angles of M in F: turns about three axes, each turned by "
      "those before "
      "it. The second lies within +-90 deg, of Euler angles within 0 to 180 deg, the others within +-180 "
      "deg.",
      {text("from", "marker F that it is seen from, \"body.marker\"").required(),
       text("to", "marker M that it is taken of").required(),
       choice("sequence", rotation_sequences(), "axes of the turns").or_default("xyz"),
       integer("angle", "which of the three: 1, 2 or 3").required().at_least(1).at_most(3)},
      {{"", "rad", ""}},
      [](const std::string& name, const Section& s, const ReadContext& c) -> std::shared_ptr<const Measure> {
        return std::make_shared<RotationAngle>(name, c.marker(s, "from"), c.marker(s, "to"),
                                               axes_of_sequence(s.text("sequence")), s.integer("angle") - 1);
      }};
}

template <AccelerationMeasure::Kind kind>
MeasureType acceleration(const char* name, const char* doc) {
  using namespace input;
  MeasureType type;
  type.name = name;
  type.doc = std::string(doc) + " Formulas may read it: see `load_cell`.";
  type.keys = {text("from", "marker F that it is seen from; \"ground\" for the absolute one").required(),
               text("to", "marker M that it is taken of").required(),
               text("axes", "marker in whose axes the direction stands; without it F"),
               vector3("direction", dim::none, "of the component, in the axes that `axes` says").required()};
  type.gives = {{"", kind == AccelerationMeasure::Kind::linear ? "m/s^2" : "rad/s^2", ""}};
  type.read = [](const std::string& own, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Measure> {
    const int F = c.marker(s, "from");
    return std::make_shared<AccelerationMeasure>(own, kind, F, c.marker(s, "to"),
                                                 s.has("axes") ? c.marker(s, "axes") : F, read_direction(s));
  };
  return type;
}

MeasureType load_cell() {
  using namespace input;
  return {
      "load_cell",
      "Component of the force through a joint, or of the torque, on the body of the joint's `to`, in axes "
      "and about a "
      "point of choice. Where formulas of forces, controls or drives by acceleration read it (friction that "
      "follows its load), it "
      "is solved for together with the accelerations; what has no solution, like friction that locks by the "
      "load it makes, "
      "stops the run and says so.",
      {text("joint", "the joint").required(),
       choice("quantity", {"force", "torque"}, "which of the two").or_default("force"),
       text("at", "marker about whose origin the torque is taken; without it the joint's `to`"),
       text("axes", "marker in whose axes the direction stands; without it the joint's `from`"),
       vector3("direction", dim::none, "of the component, in the axes that `axes` says").required()},
      {{"", "N, of a torque N*m", ""}},
      [](const std::string& name, const Section& s, const ReadContext& c) -> std::shared_ptr<const Measure> {
        const int j = c.joint(s, "joint");
        const JointDescription& joint = c.description().joints[static_cast<std::size_t>(j)];
        if (joint.joint->n_rows() == 0)
          s.refuse("joint", "leaves all six directions free: nothing goes through it",
                   "take a joint that holds");
        const bool is_torque = s.text("quantity") == "torque";
        if (s.has("at") && !is_torque)
          s.refuse("at", "is for a torque", "a force is the same about every point; take the key away");
        return std::make_shared<LoadCell>(
            name, is_torque ? LoadCell::Kind::torque : LoadCell::Kind::force, j, joint.marker_F,
            joint.marker_M, s.has("at") ? c.marker(s, "at") : joint.marker_M,
            s.has("axes") ? c.marker(s, "axes") : joint.marker_F, read_direction(s));
      }};
}

MeasureType surface_distance() {
  using namespace input;
  MeasureType type;
  type.name = "surface_distance";
  type.doc =
      "How near the surfaces of two bodies come to each other, as they are deformed, 0 where they cross: of "
      "the superelements' "
      "facets, "
      "which stand off round faces a little. Formulas may read it.";
  type.keys = {
      input::text("from", "one body, made of a superelement with pictures, of any fidelity").required(),
      input::text("to", "the other").required()};
  type.gives = {{"", "m", ""}};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Measure> {
    const int a = c.body(s, "from"), b = c.body(s, "to");
    if (a == b) s.refuse("to", "is the same body", "name another one");
    return std::make_shared<SurfaceDistance>(name, a, c.marker(s, "from"), c.mesh(s, "from", a), b,
                                             c.marker(s, "to"), c.mesh(s, "to", b));
  };
  type.meshes_of = {"from", "to"};
  return type;
}

MeasureType expression() {
  return {"expression",
          "A formula of t, parameters, joint coordinates and the measures above it.",
          {input::expression("value", "the formula, in SI").required(), unit_key("its value")},
          {{"", "that of `unit`", ""}},
          [](const std::string& name, const input::Section& s,
             const ReadContext& context) -> std::shared_ptr<const Measure> {
            return std::make_shared<ExpressionMeasure>(name, context.expression(s, "value"), read_unit(s));
          }};
}

}  // namespace

const std::vector<MeasureType>& measure_types() {
  static const std::vector<MeasureType> types = {
      relative<RelativeQuantity::distance>("distance", "Distance of two markers."),
      relative<RelativeQuantity::distance_rate>("distance_rate",
                                                "Time derivative of the distance of two markers."),
      relative<RelativeQuantity::position>("position", "Component of the position of M in F."),
      also_called(
          relative<RelativeQuantity::axis>("axis", "Component of the z axis of M in F, a direction cosine."),
          {"direction_cosine"}),
      relative<RelativeQuantity::velocity>("velocity", "Component of the velocity of M as seen from F."),
      relative<RelativeQuantity::angle>("angle", "Angle of M about the z axis of F, within +-180 deg."),
      relative<RelativeQuantity::angular_velocity>("angular_velocity",
                                                   "Component of the angular velocity of M as seen from F."),
      also_called(rotation_angle(), {"euler_angle", "cardan_angle"}),
      also_called(acceleration<AccelerationMeasure::Kind::linear>(
                      "acceleration", "Component of the acceleration of M as seen from F."),
                  {"accelerometer"}),
      acceleration<AccelerationMeasure::Kind::angular>(
          "angular_acceleration", "Component of the angular acceleration of M as seen from F."),
      also_called(load_cell(), {"force_sensor"}),
      reaction_type(),
      also_called(surface_distance(), {"clearance"}),
      also_called(expression(), {"formula"}),
      user_measure()};
  return types;
}

}  // namespace flexura::mbs
