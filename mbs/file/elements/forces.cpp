// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <array>
#include <optional>

#include "mbs/file/elements/element_types.hpp"
#include "mbs/file/elements/read_path.hpp"
#include "mbs/file/elements/user_library.hpp"
#include "mbs/forces/actuator.hpp"
#include "mbs/forces/applied.hpp"
#include "mbs/forces/bushing.hpp"
#include "mbs/forces/distributed_load.hpp"
#include "mbs/forces/joint_force.hpp"
#include "mbs/forces/joint_spring_damper.hpp"
#include "mbs/forces/line_force.hpp"
#include "mbs/forces/moving_load.hpp"
#include "mbs/forces/spring_damper.hpp"
#include "mbs/measures/relative_measure.hpp"

/// Forces in a mechanism file; contacts.cpp and frictions.cpp hold the rest.
namespace flexura::mbs {
namespace {

template <bool is_torque>
std::shared_ptr<const ForceElement> read_applied(const std::string& name, const input::Section& s,
                                                 const ReadContext& context) {
  Applied::Components components;
  const char* keys[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i)
    if (s.has(keys[i])) components[i] = context.expression(s, keys[i]);
  if (!components[0] && !components[1] && !components[2])
    s.refuse("", "none of x, y, z is given", "write at least one component");
  return std::make_shared<Applied>(
      name, is_torque, context.marker(s, "marker"), s.has("axes") ? context.marker(s, "axes") : -1,
      s.has("reaction") ? context.marker(s, "reaction") : -1, std::move(components));
}

ForceType applied(bool is_torque) {
  using namespace input;
  const Dimension d = is_torque ? dim::torque : dim::force;
  const auto component = [&](const char* name) {
    Key key = expression(name, "component, a formula of t, parameters, joint coordinates and measures");
    key.dimension = d;
    return key;
  };
  ForceType type;
  type.name = is_torque ? "torque" : "force";
  type.doc = is_torque ? "A torque at a marker, by formulas." : "A force at a marker, by formulas.";
  type.keys = {
      text("marker", "where it acts, \"body.marker\"").required(),
      component("x"),
      component("y"),
      component("z"),
      text("axes", "marker whose axes the components refer to; without it the world's"),
      text("reaction", "marker of the body that takes the reaction, at the same point; without it none")};
  type.gives = {{"x, y, z", is_torque ? "N*m" : "N", "component in its axes"}};
  type.read = is_torque ? read_applied<true> : read_applied<false>;
  return type;
}

ForceType moving_load() {
  using namespace input;
  const auto component = [](const char* name) {
    return expression(name, dim::force,
                      "component, a formula of t, parameters, joint coordinates and measures");
  };
  return {"moving_load",
          "A given force that travels along a line of a body that deforms: the particle of the line at "
          "`place` bears it, "
          "shared among the markers of the path; before and behind the path nothing does.",
          {path_key().required(),
           expression(
               "place", dim::length,
               "how far from the first marker, along the undeformed line: a formula of t, parameters, joint "
               "coordinates and measures")
               .required(),
           component("x"), component("y"), component("z"),
           text("axes", "marker whose axes the components refer to; without it the world's")},
          {{"place", "m", "where along the path, by the undeformed body"},
           {"x, y, z", "N", "component in its axes; 0 beyond the path"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            MovingLoad::Components components;
            const char* keys[] = {"x", "y", "z"};
            for (std::size_t i = 0; i < 3; ++i)
              if (s.has(keys[i])) components[i] = context.expression(s, keys[i]);
            if (!components[0] && !components[1] && !components[2])
              s.refuse("", "none of x, y, z is given", "write at least one component");
            return std::make_shared<MovingLoad>(name, read_path(s, context), context.expression(s, "place"),
                                                s.has("axes") ? context.marker(s, "axes") : -1,
                                                std::move(components));
          }};
}

ForceType spring_damper() {
  using namespace input;
  return {"spring_damper",
          "Spring and damper along the line between two markers.",
          {text("from", "one end, \"body.marker\"").required(), text("to", "the other end").required(),
           quantity("stiffness", dim::stiffness, "force per stretch").or_default("0 N/m").at_least(0.0),
           quantity("damping", dim::damping, "force per rate of stretch").or_default("0 N*s/m").at_least(0.0),
           quantity("free_length", dim::length, "length without force").or_default("0 m").at_least(0.0),
           quantity("preload", dim::force, "tension at free length").or_default("0 N"),
           text("curve", "table of the spring's tension against the stretch, added"),
           text("damping_curve", "table of the damper's tension against the rate of stretch, added")},
          {{"force", "N", "tension of the spring and damper"}, {"length", "m", "distance of its ends"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            return std::make_shared<SpringDamper>(
                name, context.marker(s, "from"), context.marker(s, "to"),
                SpringDamper::Law{
                    .stiffness = s.quantity("stiffness"),
                    .damping = s.quantity("damping"),
                    .free_length = s.quantity("free_length"),
                    .preload = s.quantity("preload"),
                    .curve = s.has("curve") ? context.table(s, "curve") : nullptr,
                    .damping_curve = s.has("damping_curve") ? context.table(s, "damping_curve") : nullptr});
          }};
}

ForceType line_force() {
  using namespace input;
  Key value = expression(
      "value",
      "force that pushes the ends apart: a formula of t, parameters, joint coordinates, measures and, for "
      "a force NAME, of its own NAME.length [m] and NAME.rate [m/s]");
  value.dimension = dim::force;
  return {"line_force",
          "A force along the line between two markers, by a formula.",
          {text("from", "one end, \"body.marker\"").required(), text("to", "the other end").required(),
           std::move(value).required()},
          {{"force", "N", "along the line, positive where it pushes its ends apart"},
           {"length", "m", "distance of its ends"},
           {"rate", "m/s", "of the length"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const int P = context.marker(s, "from"), Q = context.marker(s, "to");
            if (P == Q) s.refuse("to", "is the marker `from`", "a line needs two ends");
            context.add_measure(
                s, std::make_shared<MeasureOfElement>(name + ".length", P, Q, RelativeQuantity::distance()));
            context.add_measure(s, std::make_shared<MeasureOfElement>(name + ".rate", P, Q,
                                                                      RelativeQuantity::distance_rate()));
            return std::make_shared<LineForce>(name, P, Q, context.expression(s, "value"));
          }};
}

ForceType joint_force() {
  using namespace input;
  return {"joint_force",
          "A force or torque along a joint's coordinate, by a formula; positive where it speeds the "
          "coordinate up.",
          {text("joint", "the joint").required(),
           text("coordinate", "its coordinate, where it has more than one: \"angle\", \"position\", ..."),
           expression("value",
                      "N, or N m for an angle: a formula of t, parameters, joint coordinates and measures")
               .required()},
          {{"force", "N or N*m", "along the coordinate"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const CoordinateRef c = context.speed(s, "joint", "coordinate");
            return std::make_shared<JointForce>(name, c, context.expression(s, "value"),
                                                context.force_along(c));
          }};
}

ForceType joint_spring_damper() {
  using namespace input;
  const auto any = [](const char* name, const char* doc) {
    // The unit depends on the joint's coordinate: N m/rad or N/m, so any unit may stand here.
    return expression(name, doc).or_default("0");
  };
  return {"joint_spring_damper",
          "Spring and damper along a joint's coordinate; on a revolute joint a torsion spring.",
          {text("joint", "the joint").required(),
           text("coordinate", "its coordinate, where it has more than one: \"angle\", \"position\", ..."),
           any("stiffness", "N/m, or N m/rad"), any("damping", "N s/m, or N m s/rad"),
           any("rest", "coordinate without force: m, or rad"),
           any("preload", "force against the coordinate at rest"),
           text("curve", "table of the spring's force or torque against coordinate - rest, added"),
           text("damping_curve", "table of the damper's against the speed, added")},
          {{"force", "N or N*m", "along the coordinate"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const CoordinateRef c = context.speed(s, "joint", "coordinate");
            const auto constant = [&](const char* key) { return context.number(s, key); };
            const double stiffness = constant("stiffness"), damping = constant("damping");
            if (stiffness < 0.0) s.refuse("stiffness", "must not be negative");
            if (damping < 0.0) s.refuse("damping", "must not be negative");
            return std::make_shared<JointSpringDamper>(
                name, c,
                JointSpringDamper::Law{
                    .stiffness = stiffness,
                    .damping = damping,
                    .rest = constant("rest"),
                    .preload = constant("preload"),
                    .curve = s.has("curve") ? context.table(s, "curve") : nullptr,
                    .damping_curve = s.has("damping_curve") ? context.table(s, "damping_curve") : nullptr},
                context.force_along(c));
          }};
}

ForceType bushing() {
  using namespace input;
  return {
      "bushing",
      "Elastic and damped joint between two markers in all six directions.",
      {text("from", "marker F, in whose axes it is described").required(), text("to", "marker M").required(),
       quantities("stiffness", dim::stiffness, "along x, y, z").or_default("[0, 0, 0]").sized(3),
       quantities("rotational_stiffness", dim::angular_stiffness, "about x, y, z")
           .or_default("[0, 0, 0]")
           .sized(3),
       quantities("damping", dim::damping, "along x, y, z").or_default("[0, 0, 0]").sized(3),
       quantities("rotational_damping", dim::angular_damping, "about x, y, z")
           .or_default("[0, 0, 0]")
           .sized(3),
       matrix("stiffness_matrix", "6 x 6 in SI units, translations first, symmetric; added to the others"),
       text("curve_x", "table of the force against the deflection along x, added to the others"),
       text("curve_y", "the same along y"), text("curve_z", "along z"),
       text("curve_rx", "table of the torque against the rotation about x"), text("curve_ry", "about y"),
       text("curve_rz", "about z")},
      {{"force_x, force_y, force_z", "N", "on the body of `to`, in the axes of `from`"},
       {"torque_x, torque_y, torque_z", "N*m", "on the body of `to`, in the axes of `from`"}},
      [](const std::string& name, const Section& s,
         const ReadContext& context) -> std::shared_ptr<const ForceElement> {
        Matrix6d K = Matrix6d::Zero(), D = Matrix6d::Zero();
        const auto fill = [&](Matrix6d& A, const char* key, int first) {
          const std::vector<double> x = s.quantities(key);
          for (int i = 0; i < 3; ++i) A(first + i, first + i) += x[i];
        };
        fill(K, "stiffness", 0);
        fill(K, "rotational_stiffness", 3);
        fill(D, "damping", 0);
        fill(D, "rotational_damping", 3);
        for (int i = 0; i < 6; ++i)
          if (D(i, i) < 0.0) s.refuse(i < 3 ? "damping" : "rotational_damping", "must not be negative");
        if (s.has("stiffness_matrix")) {
          const Eigen::MatrixXd extra = s.matrix("stiffness_matrix");
          if (extra.rows() != 6 || extra.cols() != 6) s.refuse("stiffness_matrix", "is not 6 x 6");
          if ((extra - extra.transpose()).cwiseAbs().maxCoeff() > 1e-12 * extra.cwiseAbs().maxCoeff())
            s.refuse("stiffness_matrix", "is not symmetric", "an elastic bushing has an energy");
          K += extra;
        }
        Bushing::Laws curves;
        const char* keys[] = {"curve_x", "curve_y", "curve_z", "curve_rx", "curve_ry", "curve_rz"};
        for (int i = 0; i < 6; ++i)
          if (s.has(keys[i])) curves[i] = context.table(s, keys[i]);
        return std::make_shared<Bushing>(name, context.marker(s, "from"), context.marker(s, "to"), K, D,
                                         std::move(curves));
      }};
}

ForceType actuator() {
  using namespace input;
  return {
      "actuator",
      "A motor or cylinder: a force along a joint's coordinate, or along the line between two markers "
      "(positive pushes them apart), that follows a command with a lag and within limits.",
      {text("joint", "the joint"),
       text("coordinate", "its coordinate, where it has more than one: \"angle\", \"position\", ..."),
       text("from", "instead of joint: marker at one end"), text("to", "marker at the other end"),
       expression(
           "command",
           "N, or N m for an angle: a formula of t, parameters, joint coordinates, measures, controls and "
           "inputs")
           .required(),
       quantity("time_constant", dim::time, "time in which 63 % of a step of the command are followed")
           .required()
           .above(0.0),
       expression("max_force", "greatest force either way, N or N m; without it none"),
       expression("no_load_speed",
                  "speed at which max_force has fallen to 0, m/s or rad/s; without it never"),
       expression("start", "force at the start, a formula of parameters").or_default("0")},
      {{"force", "N or N*m", "along the coordinate, or the line between the markers"},
       {"command", "N or N*m", "what is asked for, within the limits"},
       {"speed", "m/s or rad/s", "along the coordinate, or the line between the markers"}},
      [](const std::string& name, const Section& s,
         const ReadContext& context) -> std::shared_ptr<const ForceElement> {
        std::optional<CoordinateRef> coordinate;
        int P = -1, Q = -1;
        if (s.has("joint")) {
          for (const char* key : {"from", "to"})
            if (s.has(key)) s.refuse(key, "stands beside joint", "keep one of them");
          coordinate = context.speed(s, "joint", "coordinate");
        } else if (s.has("from") && s.has("to")) {
          P = context.marker(s, "from");
          Q = context.marker(s, "to");
        } else {
          s.refuse("", "acts on nothing", "give joint, or from and to");
        }
        Actuator::Law law{context.expression(s, "command"), s.quantity("time_constant"),
                          context.number(s, "start")};
        for (const auto& [key, value] :
             {std::pair("max_force", &law.limit), std::pair("no_load_speed", &law.no_load_speed)}) {
          if (!s.has(key)) continue;
          *value = context.number(s, key);
          if (!(*value > 0.0)) s.refuse(key, "must be above 0");
        }
        if (s.has("no_load_speed") && !s.has("max_force"))
          s.refuse("no_load_speed", "needs max_force", "say what falls to 0 there");
        law.along = coordinate ? context.force_along(*coordinate) : dim::force;
        return std::make_shared<Actuator>(name, coordinate, P, Q, std::move(law));
      }};
}

ForceType distributed_load() {
  using namespace input;
  ForceType type;
  type.name = "distributed_load";
  type.doc =
      "A load case of a superelement (pressure, gravity, rotation, a field or a preload, `[load.NAME]` in "
      "its "
      "part file) times a formula. Its forces turn with the body; on a rigid body they act by their "
      "resultant. "
      "With `modal-stiffened` it changes the body's stiffness, too.";
  type.keys = {text("body", "the body, of a superelement that was reduced with load cases").required(),
               text("load", "name of the load case").required(),
               expression("factor", "factor, a formula of t, parameters, joint coordinates and measures")
                   .or_default("1")};
  type.gives = {{"factor", "", "factor of the load case"}};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const ForceElement> {
    const int body = c.body(s, "body");
    const std::vector<BodyLoad>& loads = c.description().bodies[body].loads;
    const std::string wanted = s.text("load");
    std::vector<std::string> known;
    for (std::size_t i = 0; i < loads.size(); ++i) {
      if (loads[i].name == wanted)
        return std::make_shared<DistributedLoad>(name, body, static_cast<int>(i), c.marker(s, "body"),
                                                 c.expression(s, "factor"));
      known.push_back(loads[i].name);
    }
    s.refuse("load",
             fmt::format("body \"{}\" has no load case \"{}\"{}", s.text("body"), wanted,
                         input::suggestion(wanted, known)),
             c.description().bodies[body].superelement.empty()
                 ? "load cases belong to superelements: name a body made of one"
             : known.empty() ? "write [load." + wanted + "] into its part file and reduce it again"
                             : "");
  };
  return type;
}

}  // namespace

const std::vector<ForceType>& force_types() {
  static const std::vector<ForceType> types = [] {
    std::vector<ForceType> list = {
        also_called(spring_damper(), {"spring", "damper", "tsda"}),
        also_called(line_force(), {"point_to_point_force"}),
        also_called(applied(false), {"point_force", "vector_force"}),
        also_called(applied(true), {"moment", "vector_torque"}),
        also_called(joint_force(), {"joint_torque"}),
        also_called(joint_spring_damper(), {"joint_spring", "torsion_spring", "rsda"}),
        also_called(bushing(), {"rubber_mount"}),
        actuator(),
        also_called(distributed_load(), {"load_case"}),
        moving_load()};
    for (auto&& group :
         {contact_types(), surface_contact_types(), gear_types(), bearing_types(), friction_types()})
      list.insert(list.end(), group.begin(), group.end());
    list.push_back(user_force());
    return list;
  }();
  return types;
}

}  // namespace flexura::mbs
