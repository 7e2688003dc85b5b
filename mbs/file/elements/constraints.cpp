// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "mbs/constraints/coupler.hpp"
#include "mbs/constraints/geometric.hpp"
#include "mbs/constraints/point_on_curve.hpp"
#include "mbs/constraints/point_on_path.hpp"
#include "mbs/constraints/rolling_disc.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "mbs/file/elements/read_curve.hpp"
#include "mbs/file/elements/read_expression_constraint.hpp"
#include "mbs/file/elements/read_path.hpp"
#include "mbs/file/elements/user_library.hpp"

/// Constraints in a mechanism file.
namespace flexura::mbs {
namespace {

/// What a key says of one coordinate.
Coupler::Term term(const ReadContext& c, CoordinateRef coordinate, double factor, std::string label) {
  return {coordinate, factor, std::move(label), c.coordinate_info(coordinate)};
}

input::Key offset() {
  return input::expression(
             "offset",
             "value of the sum: a formula of t, parameters, inputs, states of controls and algebraic states "
             "of these")
      .or_default("0");
}

std::vector<input::Key> ends() {
  return {input::text("from", "marker F, \"body.marker\"").required(),
          input::text("to", "marker M").required()};
}

std::vector<Given> forces() {
  return {{"force", "N", "size of the force between the bodies"},
          {"force_x, force_y, force_z", "N", "force on the body of `to`, in the axes of the marker `from`"}};
}

std::vector<Given> torques() {
  return {{"torque", "N*m", "size of the torque between the bodies"},
          {"torque_x, torque_y, torque_z", "N*m",
           "torque on the body of `to` about its marker, in the axes of the marker `from`"}};
}

std::vector<Given> both() {
  std::vector<Given> list = forces();
  for (Given& given : torques()) list.push_back(std::move(given));
  return list;
}

template <class Row>
ConstraintType geometric(const char* name, const char* doc, std::vector<Given> gives) {
  return {name, doc, ends(), std::move(gives),
          [](const std::string& own, const input::Section& s,
             const ReadContext& c) -> std::shared_ptr<const Constraint> {
            return std::make_shared<RelativeConstraint>(own, c.marker(s, "from"), c.marker(s, "to"),
                                                        std::make_shared<Row>());
          }};
}

ConstraintType point_on_line() {
  return geometric<PointOnLine>("point_on_line", "The origin of M stays on the z axis of F.", forces());
}

ConstraintType point_on_plane() {
  return geometric<PointOnPlane>("point_on_plane", "The origin of M stays in the xy plane of F.", forces());
}

ConstraintType point_on_curve() {
  using namespace input;
  ConstraintType type;
  type.name = "point_on_curve";
  type.doc =
      "The origin of M stays on a curve fixed in F. How far along it stands, as the sum of the chords from "
      "the first point, is an algebraic state; rounds on a closed curve count on.";
  type.keys = {text("from", "marker F that carries the curve").required(), text("to", "marker M").required()};
  for (Key& key : space_curve_keys()) type.keys.push_back(std::move(key));
  type.keys.push_back(
      quantity("near", dim::length, "where along the curve M starts, for one that crosses itself"));
  type.gives = forces();
  type.gives.push_back({"contact", "m", "how far along the curve M stands"});
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Constraint> {
    const double near = s.has("near") ? s.quantity("near") : std::numeric_limits<double>::quiet_NaN();
    return std::make_shared<RelativeConstraint>(name, c.marker(s, "from"), c.marker(s, "to"),
                                                std::make_shared<PointOnCurve>(read_space_curve(s), near));
  };
  return type;
}

std::shared_ptr<const Constraint> read_point_on_path(const std::string& name, const input::Section& s,
                                                     const ReadContext& c) {
  const std::shared_ptr<const BodyPath> path = read_path(s, c);
  const int M = c.marker(s, "to");
  if (c.undeformed(M).first == c.undeformed(path->marker(0)).first)
    s.refuse("to", fmt::format("\"{}\" is on the body of the path", s.text("to")),
             "name a marker of what travels");
  PointOnPath::Law law;
  const std::string word = s.text("orientation");
  law.orientation = word == "free"    ? PathOrientation::free
                    : word == "along" ? PathOrientation::along
                                      : PathOrientation::fixed;
  law.goes_on = s.text("ends") == "straight";
  if (s.has("place")) law.place = c.motion_expression(s, "place");
  if (s.has("near")) law.near = s.quantity("near");
  if (s.has("near") && s.has("place"))
    s.refuse("near", "stands beside place, which says where", "take it away");
  for (const auto& [key, at] : {std::pair("near", s.has("near") ? law.near : 0.0),
                                std::pair("place", law.place && !law.place.follows()
                                                       ? law.place.formula()->time_derivatives(0.0).value
                                                       : 0.0)})
    if (!law.goes_on && !path->holds(at))
      s.refuse(
          key,
          fmt::format("is {:.6g} m at the start, not on the path from 0 to {:.6g} m", at, path->length()),
          "start on the path, let it be longer, or write ends = \"straight\"");
  return std::make_shared<PointOnPath>(name, path, M, std::move(law));
}

ConstraintType point_on_path() {
  using namespace input;
  return {
      "point_on_path",
      "The origin of M travels along a line of a body that deforms, and deforms with it: a trolley on a "
      "girder, a "
      "slider on a rail that bends. How far along it stands, by the undeformed body and from the first "
      "marker on "
      "(NAME.place), is free, or a given function of time.",
      {path_key().required(), text("to", "marker M of what travels, \"body.marker\"").required(),
       choice("orientation", {"free", "along", "fixed"},
              "free: a ball on a rail; along: the x axis of M keeps along the deformed line; fixed: nor does "
              "M turn "
              "about it, its y axis to the side of the path and z up (a prismatic joint whose axis bends)")
           .or_default("free"),
       expression("place", dim::length,
                  "drives it: where along the path M stands, a formula of t, parameters and states of "
                  "controls; without "
                  "it free"),
       choice("ends", {"stop", "straight"},
              "where M passes an end of the path: stop: the run ends there and says so; straight: the path "
              "goes on "
              "straight, without flexibility of its own")
           .or_default("stop"),
       quantity("near", dim::length, "where along the path M starts, for a path that comes near itself")},
      {{"place", "m", "where along the path, by the undeformed body"},
       {"speed", "m/s", "rate of the place"},
       {"force", "N", "size of the force between the bodies"},
       {"force_x, force_y, force_z", "N",
        "force on the body of `to`, in the axes of the path there: along it, to its side, up"},
       {"torque", "N*m", "size of the torque between the bodies, of the orientations along and fixed"},
       {"torque_x, torque_y, torque_z", "N*m",
        "torque on the body of `to` about its marker, in the axes of the path there, of the orientations "
        "along "
        "and fixed"}},
      read_point_on_path};
}

ConstraintType orientation() {
  return geometric<Orientation>("orientation", "M keeps the orientation of F; its origin is free.",
                                torques());
}

ConstraintType parallel() {
  return geometric<Parallel>("parallel", "The z axes of F and M stay parallel.", torques());
}

ConstraintType perpendicular() {
  return geometric<Perpendicular>("perpendicular", "The z axes of F and M stay perpendicular.", torques());
}

ConstraintType distance() {
  ConstraintType type;
  type.name = "distance";
  type.doc =
      "The origins of F and M keep a distance, which may change in time: a massless link with ball joints, a "
      "hoist, an "
      "ideal actuator.";
  type.keys = ends();
  type.keys.push_back(
      input::expression("length", input::dim::length,
                        "the distance: a formula of t, parameters, inputs, states of controls and "
                        "algebraic states of these, positive")
          .required());
  type.gives = forces();
  type.gives.push_back({"tension", "N", "of the link: positive where it pulls its ends together"});
  type.read = [](const std::string& own, const input::Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Constraint> {
    const int F = c.marker(s, "from"), M = c.marker(s, "to");
    const Prescribed length = c.motion_expression(s, "length");
    if (!length.follows())
      if (const double at_start = length.formula()->time_derivatives(0.0).value; !(at_start > 0.0))
        s.refuse("length", length.moves() ? fmt::format("is {:.6g} m at t = 0, and must be above 0", at_start)
                                          : "must be above 0");
    if (length.moves())
      return std::make_shared<RelativeConstraint>(own, F, M, std::make_shared<Span>(), length);
    return std::make_shared<RelativeConstraint>(
        own, F, M, std::make_shared<Distance>(length.formula()->time_derivatives(0.0).value));
  };
  return type;
}

ConstraintType coupler() {
  using namespace input;
  return {
      "coupler",
      "A weighted sum of joint coordinates has a value: sum of factors[i] * (coordinate of joints[i]) = "
      "offset.",
      {texts("joints", "joints with one coordinate, or \"joint.coordinate\"").required(),
       quantities("factors", dim::none, "one for each, in SI units of the coordinates").required(), offset()},
      {{"force_1, torque_1", "N or N*m",
        "what it puts on the coordinate of its first joint: a force on a length, a torque on an angle; "
        "likewise "
        "those of the second, third ... joint"}},
      [](const std::string& name, const Section& s,
         const ReadContext& c) -> std::shared_ptr<const Constraint> {
        const std::vector<std::string> joints = s.texts("joints");
        const std::vector<double> factors = s.quantities("factors");
        if (joints.size() != factors.size() || joints.empty())
          s.refuse("factors", "does not have one entry for each of joints");
        std::vector<Coupler::Term> terms;
        for (std::size_t i = 0; i < joints.size(); ++i)
          terms.push_back(term(c, c.coordinate(s, "joints", joints[i]), factors[i], std::to_string(i + 1)));
        return std::make_shared<Coupler>(name, std::move(terms), c.motion_expression(s, "offset"));
      }};
}

ConstraintType gear() {
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
          {{"torque_1, torque_2", "N*m",
            "on the coordinates of its joints (force_1, force_2 in N on those that slide)"}},
          [](const std::string& name, const Section& s,
             const ReadContext& c) -> std::shared_ptr<const Constraint> {
            const double ratio =
                s.quantity("teeth_2") / s.quantity("teeth_1") * (s.flag("internal") ? -1.0 : 1.0);
            std::vector<Coupler::Term> terms{
                term(c, c.coordinate(s, "joint_1", s.text("joint_1")), 1.0, "1"),
                term(c, c.coordinate(s, "joint_2", s.text("joint_2")), ratio, "2")};
            return std::make_shared<Coupler>(name, std::move(terms), c.motion_expression(s, "offset"));
          }};
}

ConstraintType rack_and_pinion() {
  using namespace input;
  return {"rack_and_pinion",
          "A rack driven by a pinion: position - radius * angle = offset; a negative radius turns the sense "
          "round.",
          {text("rack", "joint of the rack, or \"joint.coordinate\"").required(),
           text("pinion", "joint of the pinion").required(),
           quantity("radius", dim::length, "pitch radius of the pinion").required(), offset()},
          {{"force_rack", "N", "on the rack's coordinate"},
           {"torque_pinion", "N*m", "on the pinion's coordinate"}},
          [](const std::string& name, const Section& s,
             const ReadContext& c) -> std::shared_ptr<const Constraint> {
            std::vector<Coupler::Term> terms{
                term(c, c.coordinate(s, "rack", s.text("rack")), 1.0, "rack"),
                term(c, c.coordinate(s, "pinion", s.text("pinion")), -s.quantity("radius"), "pinion")};
            return std::make_shared<Coupler>(name, std::move(terms), c.motion_expression(s, "offset"));
          }};
}

ConstraintType rolling_disc() {
  using namespace input;
  return {"rolling_disc",
          "A thin disc about the z axis of M rolls without slip on the xy plane of F (nonholonomic).",
          {text("from", "marker F on the body with the plane").required(),
           text("to", "marker M at the disc's centre, z along its axis").required(),
           quantity("radius", dim::length, "of the disc").required().above(0.0)},
          both(),
          [](const std::string& name, const Section& s,
             const ReadContext& c) -> std::shared_ptr<const Constraint> {
            return std::make_shared<RollingDisc>(name, c.marker(s, "from"), c.marker(s, "to"),
                                                 s.quantity("radius"));
          }};
}

}  // namespace

const std::vector<ConstraintType>& constraint_types() {
  static const std::vector<ConstraintType> types = {also_called(point_on_line(), {"inline"}),
                                                    also_called(point_on_plane(), {"inplane"}),
                                                    point_on_curve(),
                                                    point_on_path(),
                                                    orientation(),
                                                    parallel(),
                                                    perpendicular(),
                                                    also_called(distance(), {"rod", "link"}),
                                                    coupler(),
                                                    also_called(expression_constraint(), {"formula", "gcon"}),
                                                    gear(),
                                                    rack_and_pinion(),
                                                    rolling_disc(),
                                                    user_constraint()};
  return types;
}

}  // namespace flexura::mbs
