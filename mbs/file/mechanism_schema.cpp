// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "mbs/file/bodies/read_beam_part.hpp"
#include "mbs/file/bodies/read_flexible_body.hpp"
#include "mbs/file/bodies/read_pose.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "mbs/file/elements/read_context.hpp"
#include "mbs/file/elements/user_library.hpp"
#include "mbs/file/read_joint.hpp"
#include "mbs/file/read_linked_marker.hpp"
#include "mbs/file/read_mechanism.hpp"
#include "mbs/file/read_tables.hpp"

/// What may stand in a mechanism file.
namespace flexura::mbs {
namespace {

using namespace input;

void add_pose(TableSchema& schema, const std::string& of, const std::string& axes) {
  for (Key& key : pose_keys(of, axes)) schema.keys.push_back(std::move(key));
}

TableSchema marker_schema() {
  TableSchema schema;
  schema.name = "marker";
  schema.doc = "A frame fixed in a body; joints and forces sit on markers.";
  add_pose(schema, "the marker in the body's frame (undeformed)", "the body's axes");
  schema.keys.push_back(
      text("on",
           "interface of a flexible body that carries the marker along as it deforms; without a "
           "position the marker stands there"));
  const std::vector<Key> linked = linked_marker_keys();
  schema.keys.insert(schema.keys.end(), linked.begin(), linked.end());
  return schema;
}

TableSchema shape_schema() {
  TableSchema schema;
  schema.name = "shape";
  schema.doc = "A simple solid for pictures.";
  schema.selector = "type";
  const Key color = text("color", "like \"#88aacc\"");
  TableSchema cylinder, box, sphere;
  cylinder.keys = {vector3("from", dim::length, "centre of one end, in the body's frame").required(),
                   vector3("to", dim::length, "centre of the other end, in the body's frame").required(),
                   quantity("radius", dim::length, "radius").required().above(0.0), color};
  box.keys = {vector3("center", dim::length, "centre, in the body's frame").or_default("[0, 0, 0]"),
              vector3("size", dim::length, "lengths along x, y, z of the body's frame").required(), color};
  sphere.keys = {vector3("center", dim::length, "centre, in the body's frame").or_default("[0, 0, 0]"),
                 quantity("radius", dim::length, "radius").required().above(0.0), color};
  schema.variants = {{"cylinder", cylinder}, {"box", box}, {"sphere", sphere}};
  return schema;
}

TableSchema body_schema() {
  TableSchema schema;
  schema.name = "body";
  schema.doc =
      "A rigid body by its mass properties, or a superelement. Its interfaces are markers by their names. A "
      "body without any joint floats free.";
  schema.keys = {
      quantity("mass", dim::mass, "mass; needed without a superelement").at_least(0.0),
      vector3("center", dim::length, "centre of mass in the body's frame").or_default("[0, 0, 0]"),
      quantities("inertia", dim::inertia,
                 "about the centre of mass: Ixx, Iyy, Izz, or these and Ixy, Iyz, Izx (minus the integral of "
                 "x y dm)"),
      vector3("velocity", dim::velocity, "of the origin of a free body at the start, in world axes"),
      vector3("angular_velocity", dim::angular_velocity, "of a free body at the start, in world axes"),
      table_map("marker", marker_schema(), "markers of the body"),
      table("beam", beam_part_schema(), "a beam in place of mass and inertia"),
      tables("shape", shape_schema(), "for pictures"),
  };
  const std::vector<Key> flexible = flexible_body_keys();
  schema.keys.insert(schema.keys.begin() + 3, flexible.begin(), flexible.end());
  add_pose(schema,
           "the body at the start in the world (of a subsystem, its ground), a guess for the assembly; for a "
           "free body exact; world axes",
           "world axes");
  return schema;
}

std::string in_unit(const std::string& unit) {
  return unit.empty() ? "" : " [`" + unit + "`]";
}

/// "`NAME.angle` [`rad`], ...": coordinates, speeds and accelerations, and what a joint transmits.
std::string results_doc(const Joint& joint) {
  std::string text;
  for (const auto& infos : {joint.coordinates(), joint.speeds(), joint.accelerations()})
    for (const CoordinateInfo& c : infos)
      text += fmt::format("{}`NAME.{}`{}", text.empty() ? "\n\nResults: " : ", ", c.name,
                          in_unit(si_unit(c.dimension)));
  if (joint.n_rows() > 0)
    text += fmt::format("{}forces and torques [as of every joint](#output)",
                        text.empty() ? "\n\nResults: " : "; ");
  return text + (text.empty() ? "" : ".");
}

/// A line for each, behind "Results:".
std::string results_doc(const std::vector<Given>& gives) {
  if (gives.empty()) return "";
  if (gives[0].names.empty()) return fmt::format("\n\nResult: `NAME`{}.", in_unit(gives[0].unit));
  std::string text = "\n\nResults:\n";
  for (const Given& given : gives) {
    std::string names = given.names;
    for (std::size_t at = 0; (at = names.find(", ", at)) != std::string::npos; at += 9)
      names.replace(at, 2, "`, `NAME.");
    text += fmt::format("\n- `NAME.{}`{}: {}", names, in_unit(given.unit), given.doc);
  }
  return text;
}

TableSchema joint_schema(bool is_connection) {
  TableSchema schema;
  schema.name = is_connection ? "connection" : "joint";
  schema.doc =
      is_connection
          ? "Joins two bodies like a joint; the program makes a joint of the tree of it "
            "where the joints leave a body unreached (of several connections the one with "
            "the fewest freedoms) and a constraint elsewhere. Its values at the start are "
            "guesses that a constraint ignores. Drives, couplers and formulas take its coordinates as those "
            "of a joint; one that is driven or coupled is sooner made a joint of the tree. flexura check "
            "says what it became."
          : "Joins two bodies. Joints span a tree from ground outwards (in the order of "
            "the file, a driven joint first); the others close loops as constraints, driven "
            "ones too (their angles then show without whole turns). Rows of "
            "constraints that follow from others are left out and named; they must agree "
            "with these in position, speed and acceleration, drives included, and are "
            "watched during the run: what contradicts ends it with the names of the rows "
            "and the time. Loops are closed to 1e-9 of the mechanism's size; parts that do "
            "not fit by up to 1e-6 of it are taken as they are, with a note.\n\nDrives may "
            "follow controls. A position follows t, inputs, the states of controls (state, "
            "filter, transfer_function, delay), what they read in their rates being positions, "
            "states and time, and algebraic states of all these; a speed follows positions and every control "
            "as well, also one that "
            "jumps (sample, relay: the speed then jumps with it); an acceleration follows whatever "
            "formulas of forces may read, reactions too. What is not known in time is refused, with "
            "the control that helps. The drive is ideal: its force (NAME.drive_force) is what the "
            "motion takes, and does not act on the control unless this reads it.";
  schema.selector = "type";
  schema.keys = {text("from", "marker F on the first body, \"body.marker\"").required(),
                 text("to", "marker M on the second body").required()};
  if (!is_connection)
    schema.keys.push_back(
        flag("cut",
             "close a loop here; without it the program decides, and where more than five "
             "flexible bodies with more than 100 modes hang on one another it closes the "
             "joints between them as constraints, which takes less time (false keeps one as "
             "it is; so does whatever reads, drives or loads its coordinates)"));
  for (const JointType& type : joint_types()) {
    TableSchema variant;
    const auto joint = make_joint(type.name);
    variant.doc = type.doc + results_doc(*joint);
    const auto coordinates = joint->coordinates(), speeds = joint->speeds();
    for (const CoordinateInfo& c : coordinates)
      variant.keys.push_back(quantity(c.name, c.dimension,
                                      "coordinate at the start" + component_of(c.name) +
                                          "; moves only where the others cannot close the loops"));
    for (const CoordinateInfo& c : speeds)
      variant.keys.push_back(quantity(c.name, c.dimension, "speed at the start" + component_of(c.name)));
    for (Key& key : drive_keys(*joint)) variant.keys.push_back(std::move(key));
    variant.keys.insert(variant.keys.end(), type.keys.begin(), type.keys.end());
    variant.name = type.name;  // under a synonym: what it is another name of
    for (const std::string& synonym : type.synonyms) schema.variants[synonym] = variant;
    schema.variants[type.name] = std::move(variant);
  }
  schema.variants["user"] = {.doc = "A joint of your own, out of a shared library in C++.",
                             .keys = user_joint_keys()};
  return schema;
}

template <class Types>
TableSchema element_schema(const std::string& name, const std::string& doc, const Types& types) {
  TableSchema schema;
  schema.name = name;
  schema.doc = doc;
  schema.selector = "type";
  for (const auto& type : types) {
    TableSchema variant;
    variant.doc = type.doc + results_doc(type.gives);
    variant.keys = type.keys;
    variant.name = type.name;  // under a synonym: what it is another name of
    for (const std::string& synonym : type.synonyms) schema.variants[synonym] = variant;
    schema.variants[type.name] = std::move(variant);
  }
  return schema;
}

TableSchema with_unit(TableSchema schema) {
  for (auto& [type, variant] : schema.variants) variant.keys.push_back(unit_key("its output"));
  return schema;
}

TableSchema subsystem_schema() {
  TableSchema schema;
  schema.name = "subsystem";
  schema.doc =
      "A mechanism file placed in this one, as often as wanted. Its bodies, joints and elements are named "
      "\"NAME.body\", ...; its [solver], [output] and [run] count only where it runs by itself.";
  schema.keys = {
      text("file", "the mechanism file, beside this one").required(),
      text("on", "marker of this mechanism that takes the place of its ground; without it the world"),
      formulas("parameters", "values for parameters of that file: formulas of the parameters of this one")};
  add_pose(schema, "its ground in that marker's frame", "that marker's axes");
  return schema;
}

}  // namespace

// Kept beside list_quantities(), which makes them.
constexpr const char* quantities_doc =
    R"(What is stored. `flexura check FILE` lists the quantities of a mechanism by name (with `--json` also units and
meanings); all are there for `simulate`, `statics` and `outputs`. Accelerations and forces are solved from the state of
each row, positions and velocities closed onto the constraints, so that they are as accurate as the motion. Where
constraints lose rank (a dead point, a change point) the equations do not determine the forces: a row that falls next to
such a position can be far off in them, which the run then says.

| quantities | meaning |
|---|---|
| `JOINT.COORDINATE`, speeds, accelerations | of the joint, M (marker `to`) relative to F (marker `from`) |
| `JOINT.force_x` .. `_z`, `JOINT.torque_x` .. `_z` | all that the joint transmits, its drive and the force elements on its coordinates included: force on the body of `to`, torque on it about the origin of `to`, in the axes of `from` |
| `JOINT.force`, `JOINT.torque` | their sizes |
| `JOINT.drive_force` (`.drive_force_COORDINATE` where several are driven) | force or torque of the drive along its coordinate |
| `CONSTRAINT.force_x` .. `_z`, `.torque_x` .. `_z`, `.force`, `.torque` | likewise of constraints between two markers (what a type cannot exert is left out); of a `rolling_disc` the contact force, its torque about the disc's centre |
| `CONSTRAINT.place`, `.speed` | of a `point_on_path`: where along the path, by the undeformed body, and its rate; its forces and torques, on the body of `to` about its marker, are in the axes of the path there: x along it, y to its side, z up |
| `CONSTRAINT.tension` | of a `distance`: positive where the link pulls its ends together |
| `CONSTRAINT.torque_1` .. or `.force_1` .. | of a `gear` or `coupler`: on the coordinate of its first, second ... joint |
| `CONSTRAINT.force_rack`, `.torque_pinion` | of a `rack_and_pinion`, on the coordinates |
| `CONSTRAINT.force_ROW` | of a `user` constraint that names no outputs: generalised force along the row, whose power is the force times the row's rate |
| `BODY.position_x`, `.velocity_x`, `.angular_velocity_x`, `.acceleration_x` .. | of the body's frame, in the world's axes |
| `BODY.mode_1` .., `.strain_energy`, `BODY.POINT...` | of flexible bodies |
| `BODY.von_mises`, `.strain`, `.displacement` | the largest on a flexible body's surface, with `stress` or `displacement` = true: von Mises stress, principal strain (of the largest size, with its sign), displacement by deformation; `.von_mises_x` .. `_z`, `.strain_at_x`, `.displacement_at_x` .. say where |
| `momentum.linear_x` .. `_z`, `momentum.angular_x` .. `_z` | of all bodies, in the world's axes, about the world's origin; one-way bodies as rigid ones |
| `energy.kinetic`, `.strain`, `.potential`, `.total`, `power.input`, `power.dissipated` | of the mechanism |
| `energy.input`, `.dissipated`, `.balance` | of the run, always stored; the balance is its error |
| names of measures, inputs, controls; `FORCE.OUTPUT` | values; what force elements give |

Redundant constraints leave forces open: a part of them that holds itself in balance could be any. `flexura check` marks
each quantity that such a self-stress touches with `?`; its value is the one without the rows that were left out. All
others, and sums in which the self-stress cancels (the weight that two hinges of a door carry together), are unique.)";

// Kept beside expression.hpp, which reads them.
constexpr const char* formulas_doc =
    R"(Every number of the file may be a formula of its `[parameters]`; where a key says "formula", it may also read the time `t`,
joint coordinates and speeds (`JOINT.angle`, `JOINT.speed`), measures, inputs and controls by their names. What is one number for the
whole run (stiffness, damping, limits, gains, values at the start) takes formulas of parameters, and one that reads `t` is refused.

| in formulas | |
|---|---|
| `+ - * / ^`, `( )` | arithmetic; `^` is the power |
| `< <= > >= == !=`, `&&`, `\|\|`, `a ? b : c` | comparisons give 1 or 0 |
| `pi`, `e` | constants |
| `sin cos tan asin acos atan`, `atan2(y, x)` | angles in rad |
| `sinh cosh tanh asinh acosh atanh` | hyperbolic |
| `exp`, `ln` or `log`, `log10`, `log2`, `sqrt`, `pow(x, y)` | `log` is the natural logarithm |
| `abs`, `sign`, `rint`, `floor`, `ceil`, `min`, `max` | `rint` rounds to the nearest whole number |
| `mod(x, y)` | what is left of x after whole multiples of y, of the sign of y |
| `step(x, x_0, y_0, x_1, y_1)` | the cubic from y_0 at x_0 to y_1 at x_1, level outside |
| `NAME(x)` | the table `[table.NAME]` |

)";

TableSchema mechanism_schema(TableSchema solver) {
  TableSchema ground, output, run, schema;
  ground.name = "ground";
  ground.doc = "The world; its frame is \"ground\".";
  ground.keys = {table_map("marker", marker_schema(), "markers of ground"),
                 tables("shape", shape_schema(), "for pictures")};
  output.name = "output";
  output.doc = quantities_doc;
  output.keys = {
      texts("quantities", "names, with * and ? as wildcards, like \"crank.*\"; without it the usual ones"),
      texts("y", "the outputs y of the linearised mechanism: names, with * and ? as wildcards")};
  run.name = "run";
  run.doc = "A run with some values changed.";
  run.keys = {texts("set", "\"key.path=value\" pairs, like \"body.rod.fidelity=rigid\""),
              quantity("accuracy", dim::none, "short for solver.accuracy in set, like \"1 %\"")
                  .above(0.0)
                  .at_most(1.0),
              text("state", "short for solver.initial_state in set: a [state.NAME] to start from")};

  TableSchema input_schema;
  input_schema.name = "input";
  input_schema.doc =
      "An input u of the mechanism: a function of time that formulas read by its name, and a column of B "
      "where the mechanism is linearised.";
  input_schema.keys = {input::expression("value", "a formula of t and parameters, in SI").or_default("0"),
                       unit_key("its value")};

  schema.name = "mechanism file";
  schema.doc =
      std::string("A mechanism: bodies, joints, forces, and how they are simulated.\n\n") + formulas_doc +
      "What a formula does in time is known before the run: every integrator stops where it jumps or has a "
      "kink (a comparison, abs, floor, a point of a linear table, ...), begins anew behind a jump, and takes "
      "no step over a pulse, however short and smooth, that is worth more than 1e-11 of the formula's range "
      "times the run. Comparisons, sign and rounding of what moves are switches: held between events, "
      "located "
      "to round-off, and an error where they switch without end; so are abs, min, max and the kinks of a "
      "table, where "
      "nothing jumps. == and != hold for an instant and are no "
      "events. A smooth peak over the motion (a bump in a road, a detent) is found behind the step that "
      "leapt over it, "
      "which is made again. A row that falls on an event shows what was before it.";
  schema.keys = {
      text("name", "title of results and pictures; without it the file's name"),
      vector3("gravity", dim::acceleration,
              "acceleration of free fall, in world axes; that of the file that places a subsystem counts")
          .or_default("[0, 0, -9.81]"),
      formulas(
          "parameters",
          "names for formulas; each a number, a quantity or a formula of the others. Every number of the "
          "file may be a formula of them, like position = [\"2*radius\", 0, 0]"),
      table_map("table", table_schema(), "curves through points"),
      table("ground", ground, "the world"),
      table_map("body", body_schema(), "bodies"),
      table_map("subsystem", subsystem_schema(), "mechanisms placed in this one"),
      table_map("joint", joint_schema(false), "joints"),
      table_map("connection", joint_schema(true), "joints or constraints, as the program finds best"),
      table_map("constraint",
                element_schema("constraint", "Restrains motion without being a joint.", constraint_types()),
                "constraints beside the joints"),
      table_map("force", element_schema("force", "A force element.", force_types()), "force elements"),
      table_map("measure",
                element_schema("measure", "A scalar that formulas and outputs can name.", measure_types()),
                "measured quantities"),
      table_map("input", input_schema, "inputs u"),
      table_map("control",
                with_unit(element_schema(
                    "control", "Reads signals, holds states, gives a signal of its name.", control_types())),
                "control elements"),
      table("output", output, "what is stored"),
      table("solver", std::move(solver), "the integrator"),
      table_map("state", state_schema(), "sets of states to start from"),
      table_map("run", run, "runs; without any the mechanism runs once as it stands"),
  };
  return schema;
}

}  // namespace flexura::mbs
