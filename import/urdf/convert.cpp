// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/convert.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "import/urdf/at_start.hpp"
#include "import/urdf/contacts.hpp"
#include "import/urdf/draw.hpp"
#include "import/urdf/massless.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::urdf {
namespace {

// A stop that the joint, with all that it carries, bounces on with this frequency and damping ratio; at its greatest effort it
// gives way by this part of its travel at most.
constexpr double kStopFrequency_hz = 20.0, kStopDampingRatio = 0.3, kStopYield = 0.01;
constexpr double kControlFrequency_hz = 2.0;

class Converter {
 public:
  Converter(Robot robot, const Choices& choices, Findings& findings)
      : robot_(std::move(robot)), choices_(choices), findings_(findings), drawer_(robot_.file, choices) {}

  Mechanism convert() {
    add_ground();
    q_ = start_coordinates(robot_);
    lock_joints();
    treat_massless(robot_, q_, choices_, drawer_, findings_);
    lock_joints();  // what mimics one that is fixed now
    findings_.require_no_fault();
    start_ = start_mass(robot_, q_);
    result_.name = robot_.name;
    result_.comments = {
        "imported by flexura import from " + shown(robot_.file.filename().string()),
        "Bodies have the frames of the links; the coordinates of the joints are those of the URDF."};
    for (std::size_t l = 0; l + 1 < robot_.links.size(); ++l) add_body(robot_.links[l]);
    // Names of bodies and joints are kept apart: both stand in the names of results.
    const std::string base = names_.add(robot_.joints.back().name);
    for (std::size_t j = 0; j + 1 < robot_.joints.size(); ++j)
      joint_names_.push_back(name_for("joint", robot_.joints[j].name));
    joint_names_.push_back(base);
    for (const int j : robot_.order) add_joint(static_cast<std::size_t>(j));
    for (const int j : robot_.order) add_forces(static_cast<std::size_t>(j));
    add_actuators();
    if (choices_.contacts) add_floor(robot_, q_, result_, names_, findings_);
    choose_method();
    return std::move(result_);
  }

 private:
  std::string name_for(const char* what, const std::string& wanted) {
    std::string name = names_.add(wanted);
    std::string small = wanted;
    for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    const bool is_like_another = !small_names_.insert(what + small).second;
    if (name != wanted || is_like_another)
      result_.renamed.emplace_back(fmt::format("{} \"{}\"", what, wanted), name);
    return name;
  }

  // A joint without travel is fixed where it stands, and so is what mimics one.
  void lock_joints() {
    for (bool again = true; again;) {
      again = false;
      for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
        Joint& joint = robot_.joints[j];
        if (!has_one_coordinate(joint)) continue;
        const bool follows =
            joint.mimic &&
            robot_.joints[static_cast<std::size_t>(joint.mimic->joint)].kind == JointKind::fixed;
        const bool has_no_travel = choices_.stops && !joint.mimic && joint.limit &&
                                   joint.kind != JointKind::continuous &&
                                   joint.limit->lower == joint.limit->upper;
        if (!follows && !has_no_travel) continue;
        findings_.note(
            "joints without travel",
            follows ? fmt::format("joint \"{}\" mimics one that does not move: fixed at {}",
                                  shown(joint.name), q_[j])
                    : fmt::format("joint \"{}\" has no travel, lower and upper are both {}: fixed there; "
                                  "give its limits, or let it move by --no-stops",
                                  shown(joint.name), joint.limit->lower),
            joint.line);
        fix(joint, q_[j]);
        again = true;
      }
    }
    std::erase_if(robot_.transmissions, [&](const Transmission& t) {
      return robot_.joints[static_cast<std::size_t>(t.joint)].kind == JointKind::fixed;
    });
  }

  void add_body(const Link& link) {
    Body body;
    body.name = name_for("link", link.name);
    if (body.name != link.name) body.comments.push_back("link \"" + shown(link.name) + "\"");
    if (link.inertial) {
      body.mass = link.inertial->mass;
      body.center = link.inertial->center;
      body.inertia = link.inertial->inertia;
    }
    drawer_.draw(link, body, findings_);
    result_.bodies.push_back(std::move(body));
  }

  bool is_ground(int link) const { return link == robot_.root; }
  std::string body_name(int link) const {
    return is_ground(link) ? "ground" : result_.bodies[static_cast<std::size_t>(link)].name;
  }
  std::vector<Marker>& markers_of(int link) {
    return is_ground(link) ? result_.ground : result_.bodies[static_cast<std::size_t>(link)].markers;
  }

  // The ground becomes the root, without a body, and what holds the robot's root to it the last joint.
  void add_ground() {
    const int ground = static_cast<int>(robot_.links.size()), base = static_cast<int>(robot_.joints.size());
    robot_.links[static_cast<std::size_t>(robot_.root)].parent_joint = base;
    robot_.joints.push_back({.name = "base",
                             .kind = choices_.floating_base ? JointKind::floating : JointKind::fixed,
                             .parent = ground,
                             .child = robot_.root});
    robot_.links.push_back({.name = "ground"});
    robot_.order.insert(robot_.order.begin(), base);
    robot_.root = ground;
  }

  void add_joint(std::size_t j) {
    const Joint& joint = robot_.joints[j];
    const std::string& name = joint_names_[j];
    const char* const types[] = {"revolute", "revolute", "prismatic", "fixed", "free", "planar", "spherical"};
    // The coordinate's axis is the markers' z axis.
    const bool along_axis = has_one_coordinate(joint) || joint.kind == JointKind::planar;
    const Pose X_JM{along_axis ? mbs::frame_along(joint.axis) : Matrix3d::Identity(), Vector3d::Zero()};
    markers_of(joint.parent).push_back({name, joint.X_PJ * X_JM});
    markers_of(joint.child).push_back({name, X_JM});
    Element element{"joint", name};
    if (is_ground(joint.parent))
      element.comments.emplace_back(choices_.floating_base
                                        ? "the root floats free"
                                        : "the root stands on the ground (--base floating frees it)");
    else if (name != joint.name)
      element.comments.push_back("joint \"" + shown(joint.name) + "\"");
    if (joint.limit && joint.limit->velocity > 0.0)
      element.comments.push_back(
          fmt::format("the URDF's greatest speed, {} {}, is no physical law and not enforced",
                      joint.limit->velocity, turns(joint) ? "rad/s" : "m/s"));
    element.lines = {{"type", toml(std::string(types[static_cast<int>(joint.kind)]))},
                     {"from", toml(body_name(joint.parent) + "." + name)},
                     {"to", toml(body_name(joint.child) + "." + name)}};
    if (joint.is_driven)
      for (const char* drive : drives_of(joint.kind)) element.lines.emplace_back(drive, toml(q_[j]));
    else if (q_[j] != 0.0)
      element.lines.emplace_back(turns(joint) ? "angle" : "position", toml(q_[j]));
    if (q_[j] != 0.0 && !joint.mimic)
      findings_.note(
          "joints that start at a limit",
          fmt::format("joint \"{}\" starts at its limit {}: 0 is outside", shown(joint.name), q_[j]));
    result_.elements.push_back(std::move(element));
    if (joint.mimic)
      result_.elements.push_back(
          {"constraint",
           names_.add(name + "_mimic"),
           {fmt::format("mimic: {} = {} * {} + {}", name, joint.mimic->multiplier,
                        joint_names_[static_cast<std::size_t>(joint.mimic->joint)], joint.mimic->offset)},
           {{"type", toml(std::string("coupler"))},
            {"joints", fmt::format("[{}, {}]", toml(name),
                                   toml(joint_names_[static_cast<std::size_t>(joint.mimic->joint)]))},
            {"factors", fmt::format("[1.0, {}]", toml(-joint.mimic->multiplier))},
            {"offset", toml(joint.mimic->offset)}}});
  }

  // Of all coordinates of such a joint.
  static std::vector<const char*> drives_of(JointKind kind) {
    if (kind == JointKind::planar) return {"drive_x", "drive_y", "drive_angle"};
    if (kind == JointKind::floating)
      return {"drive_x", "drive_y", "drive_z", "drive_rotation_x", "drive_rotation_y", "drive_rotation_z"};
    if (kind == JointKind::spherical) return {"drive_rotation_x", "drive_rotation_y", "drive_rotation_z"};
    return {"drive"};
  }

  // Where drives hold whatever moves, nothing is left to be integrated.
  void choose_method() {
    const auto moves = [](const Joint& joint) { return joint.kind != JointKind::fixed && !joint.mimic; };
    if (std::ranges::none_of(robot_.joints, moves) ||
        !std::ranges::all_of(robot_.joints, [&](const Joint& j) { return !moves(j) || j.is_driven; }))
      return;
    result_.solver = {{"method", toml(std::string("kinematics"))}};
    findings_.note(
        "robots for prescribed motion",
        "drives prescribe the whole motion: [solver] method = \"kinematics\"; change the drives of "
        "the joints");
  }

  // What is carried along the joint's coordinate at the start, mimicking joints aside [kg or kg m^2].
  double carried(std::size_t j) const {
    const auto at = std::ranges::find(start_.joint_of, static_cast<int>(j)) - start_.joint_of.begin();
    return start_.H(at, at);
  }

  void add_forces(std::size_t j) {
    const Joint& joint = robot_.joints[j];
    if (!has_one_coordinate(joint) || joint.is_driven) return;
    const std::string& name = joint_names_[j];
    const Line of_joint = {"joint", toml(name)};
    if (joint.friction > 0.0)
      result_.elements.push_back({"force",
                                  names_.add(name + "_friction"),
                                  {},
                                  {{"type", toml(std::string("joint_friction"))},
                                   of_joint,
                                   {"coulomb", toml(joint.friction)},
                                   {"viscous", toml(joint.damping)}}});
    else if (joint.damping > 0.0)
      result_.elements.push_back(
          {"force",
           names_.add(name + "_damping"),
           {},
           {{"type", toml(std::string("joint_spring_damper"))}, of_joint, {"damping", toml(joint.damping)}}});
    // A joint that mimics is held by the one that it mimics.
    if (!choices_.stops || !joint.limit || joint.kind == JointKind::continuous || joint.mimic) return;
    const bool has_lower = std::isfinite(joint.limit->lower), has_upper = std::isfinite(joint.limit->upper);
    if (!has_lower && !has_upper) return;
    const double least = turns(joint) ? 0.01 : 0.001,
                 travel =
                     has_lower && has_upper ? std::max(joint.limit->upper - joint.limit->lower, least) : 1.0;
    const double omega = 2.0 * std::numbers::pi * kStopFrequency_hz, inertia = carried(j);
    const double k = std::max(inertia * omega * omega, joint.limit->effort / (kStopYield * travel));
    std::vector<Line> lines = {{"type", toml(std::string("bump_stop"))}, of_joint};
    if (has_lower) lines.emplace_back("lower", toml(joint.limit->lower));
    if (has_upper) lines.emplace_back("upper", toml(joint.limit->upper));
    lines.emplace_back("stiffness", toml(k));
    lines.emplace_back("damping", toml(2.0 * kStopDampingRatio * std::sqrt(k * inertia)));
    result_.elements.push_back({"force",
                                names_.add(name + "_stop"),
                                {"stiffness and damping are chosen, the URDF has none: 20 Hz with what the "
                                 "joint carries, damping ratio 0.3, "
                                 "at most 1 % of the travel under its effort"},
                                lines});
  }

  // Those of the file; for controllers every other joint that moves by itself has one as well.
  void add_actuators() {
    std::vector<bool> has_motor(robot_.joints.size());
    for (const Transmission& transmission : robot_.transmissions) {
      add_actuator(transmission);
      has_motor[static_cast<std::size_t>(transmission.joint)] = true;
    }
    if (!choices_.controllers) return;
    for (const int j : robot_.order)
      if (const Joint& joint = robot_.joints[static_cast<std::size_t>(j)];
          has_one_coordinate(joint) && !joint.mimic && !has_motor[static_cast<std::size_t>(j)])
        add_actuator({.name = joint.name, .actuator = joint.name, .joint = j});
  }

  // The signal of a motor: an input, or a controller of the same name that follows a target.
  void add_signal(const std::string& signal, const Transmission& transmission) {
    const auto j = static_cast<std::size_t>(transmission.joint);
    const Joint& joint = robot_.joints[j];
    const std::string unit = turns(joint) ? "N m" : "N";
    if (!choices_.controllers) {
      result_.elements.push_back(
          {"input",
           signal,
           {fmt::format("effort of actuator \"{}\" [{}]; a [control.{}] of any type can take its place",
                        shown(transmission.actuator), unit, signal)},
           {{"value", "0.0"}}});
      return;
    }
    const std::string target = names_.add("target_" + transmission.actuator);
    result_.elements.push_back(
        {"input",
         target,
         {fmt::format("where joint \"{}\" is to go [{}]", shown(joint.name), turns(joint) ? "rad" : "m")},
         {{"value", toml(q_[j])}}});
    const double omega = 2.0 * std::numbers::pi * kControlFrequency_hz,
                 gain = carried(j) / transmission.reduction;
    result_.elements.push_back(
        {"control",
         signal,
         {fmt::format(
             "effort of actuator \"{}\" [{}]: PD law, 2 Hz and critically damped with what the joint "
             "carries at the start",
             shown(transmission.actuator), unit)},
         {{"type", toml(std::string("pid"))},
          {"error",
           toml(fmt::format("{} - {}.{}", target, joint_names_[j], turns(joint) ? "angle" : "position"))},
          {"proportional", toml(gain * omega * omega)},
          {"derivative", toml(2.0 * gain * omega)}}});
  }

  void add_actuator(const Transmission& transmission) {
    const auto j = static_cast<std::size_t>(transmission.joint);
    const Joint& joint = robot_.joints[j];
    if (joint.is_driven) return;
    const std::string signal = names_.add("u_" + transmission.actuator);
    add_signal(signal, transmission);
    std::string effort = fmt::format("{} * {}", toml(transmission.reduction), signal);
    if (joint.limit && joint.limit->effort > 0.0)
      effort =
          fmt::format("max({}, min({}, {}))", toml(-joint.limit->effort), toml(joint.limit->effort), effort);
    result_.elements.push_back({"force",
                                names_.add(joint_names_[j] + "_motor"),
                                {fmt::format("transmission \"{}\"", shown(transmission.name))},
                                {{"type", toml(std::string("joint_force"))},
                                 {"joint", toml(joint_names_[j])},
                                 {"value", toml(effort)}}});
  }

  Robot robot_;
  const Choices& choices_;
  Findings& findings_;
  Drawer drawer_;
  Names names_;
  std::set<std::string> small_names_;
  std::vector<std::string> joint_names_;
  std::vector<double> q_;
  StartMass start_;
  Mechanism result_;
};

}  // namespace

Mechanism to_mechanism(Robot robot, const Choices& choices, Findings& findings) {
  return Converter(std::move(robot), choices, findings).convert();
}

}  // namespace flexura::import::urdf
