// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/tree/writer.hpp"

#include <fmt/format.h>

#include <cmath>

#include "import/tree/draw.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::tree {
namespace {

Line text_line(const std::string& key, const std::string& value) {
  return {key, toml(value)};
}

const char* type_of(JointKind kind) {
  switch (kind) {
    case JointKind::fixed:
      return "fixed";
    case JointKind::revolute:
      return "revolute";
    case JointKind::prismatic:
      return "prismatic";
    case JointKind::screw:
      return "screw";
    case JointKind::spherical:
      return "spherical";
    case JointKind::free:
      return "free";
  }
  return "";
}

}  // namespace

Writer::Writer(const Tree& tree, const StartMass& mass, Findings& findings)
    : tree_(tree), mass_(mass), findings_(findings) {
  result_.name = tree.name;
  result_.comments = tree.comments;
  if (tree.gravity != Vector3d(0.0, 0.0, -9.81)) result_.head.emplace_back("gravity", toml(tree.gravity));
  int left_out = draw(tree.ground, result_.ground_shapes);
  for (const Link& link : tree.links) {
    Body body;
    body.name = names_.add(link.name);
    if (body.name != link.name) {
      body.comments.push_back("body \"" + shown(link.name) + "\"");
      result_.renamed.emplace_back(shown(link.name), body.name);
    }
    body.comments.insert(body.comments.end(), link.comments.begin(), link.comments.end());
    body.mass = link.inertial.mass;
    body.center = link.inertial.center;
    body.inertia = link.inertial.inertia;
    left_out += draw(link.solids, body);
    result_.bodies.push_back(std::move(body));
  }
  if (left_out > 0)
    findings_.note("pictures left out", fmt::format("{} shapes are not drawn: ellipsoids, boxes that are "
                                                    "turned and meshes are on bodies with mass only",
                                                    left_out));
  for (const Joint& joint : tree.joints) {
    joint_names_.push_back(names_.add(joint.name));
    if (joint_names_.back() != joint.name)
      result_.renamed.emplace_back(shown(joint.name), joint_names_.back());
  }
  for (std::size_t j = 0; j < tree.joints.size(); ++j) add_joint(j);
  for (std::size_t j = 0; j < tree.joints.size(); ++j) add_forces(j);
}

const std::string& Writer::body(int link) const {
  static const std::string ground = "ground";
  return link < 0 ? ground : result_.bodies[static_cast<std::size_t>(link)].name;
}

std::string Writer::coordinate(int j) const {
  return joint(j) + (tree_.joints[static_cast<std::size_t>(j)].turns() ? ".angle" : ".position");
}

std::string Writer::marker(int link, const std::string& wanted, const Pose& X_LM) {
  std::vector<Marker>& markers =
      link < 0 ? result_.ground : result_.bodies[static_cast<std::size_t>(link)].markers;
  markers.push_back({names_.add(wanted), X_LM});
  return body(link) + "." + markers.back().name;
}

std::string Writer::add(const std::string& table, const std::string& wanted,
                        std::vector<std::string> comments, std::vector<Line> lines) {
  const std::string name = names_.add(wanted);
  result_.elements.push_back({table, name, std::move(comments), std::move(lines)});
  return name;
}

void Writer::add_joint(std::size_t j) {
  const Joint& joint = tree_.joints[j];
  const std::string& name = joint_names_[j];
  const auto put = [&](int link, const Pose& X) {
    (link < 0 ? result_.ground : result_.bodies[static_cast<std::size_t>(link)].markers).push_back({name, X});
    return body(link) + "." + name;
  };
  Element element{"joint", name};
  if (name != joint.name && !joint.name.empty())
    element.comments.push_back("joint \"" + shown(joint.name) + "\"");
  element.comments.insert(element.comments.end(), joint.comments.begin(), joint.comments.end());
  element.lines = {text_line("type", type_of(joint.kind)), text_line("from", put(joint.parent, joint.X_PF)),
                   text_line("to", put(joint.child, joint.X_CM))};
  if (joint.kind == JointKind::screw) element.lines.emplace_back("pitch", toml(joint.pitch));
  if (joint.closes_loop) element.lines.emplace_back("cut", "true");
  if (joint.has_one_coordinate() && joint.start != 0.0)
    element.lines.emplace_back(joint.turns() ? "angle" : "position", toml(joint.start));
  if (joint.kind == JointKind::free)
    for (int k = 0; k < 3; ++k)
      if (joint.X_FM.p[k] != 0.0) element.lines.emplace_back(std::string(1, "xyz"[k]), toml(joint.X_FM.p[k]));
  if ((joint.kind == JointKind::free || joint.kind == JointKind::spherical) && !joint.closes_loop &&
      !(joint.X_FM.R - Matrix3d::Identity()).isZero(0.0)) {
    const Eigen::Vector4d q = mbs::quaternion_of_rotation(joint.X_FM.R);
    for (int k = 0; k < 4; ++k) element.lines.emplace_back(std::string("q") + "wxyz"[k], toml(q[k]));
  }
  result_.elements.push_back(std::move(element));
}

void Writer::add_forces(std::size_t j) {
  const Joint& joint = tree_.joints[j];
  if (joint.freedoms() > 1) return add_forces_in_all_directions(j);
  if (!joint.has_one_coordinate()) return;
  const std::string& name = joint_names_[j];
  if (joint.friction > 0.0)
    add("force", name + "_friction", {},
        {text_line("type", "joint_friction"), text_line("joint", name), {"coulomb", toml(joint.friction)}});
  if (joint.stiffness != 0.0 || joint.damping != 0.0) {
    std::vector<Line> lines = {text_line("type", "joint_spring_damper"), text_line("joint", name)};
    if (joint.stiffness != 0.0) {
      lines.emplace_back("stiffness", toml(joint.stiffness));
      if (joint.rest != 0.0) lines.emplace_back("rest", toml(joint.rest));
    }
    if (joint.damping != 0.0) lines.emplace_back("damping", toml(joint.damping));
    add("force", name + (joint.stiffness != 0.0 ? "_spring" : "_damping"), {}, lines);
  }
  if (joint.armature > 0.0) add_rotor(name + "_rotor", joint.armature, {{static_cast<int>(j), 1.0}});
  if (joint.lower || joint.upper) add_stop(j);
}

void Writer::add_stop(std::size_t j) {
  const Joint& joint = tree_.joints[j];
  const std::string& name = joint_names_[j];
  // Of a loop's joint nothing is known that it would carry.
  const double compliance =
      joint.closes_loop ? 0.0 : mass_.compliance({{mass_.first(static_cast<int>(j)), 1.0}});
  const double inertia = compliance > 0.0 ? 1.0 / compliance : 1.0;
  std::vector<Line> lines = {text_line("type", "bump_stop"), text_line("joint", name)};
  std::vector<std::string> comments;
  // A joint that starts at its stop and is pressed by nothing, as in free fall, would touch and leave it by
  // round-off without end.
  const auto clear = [&](double limit, double outwards) {
    constexpr double least = 1e-6;
    if (std::abs(limit - joint.start) >= least) return limit;
    comments.emplace_back("a millionth wider than in the file, where the joint starts");
    return joint.start + outwards * least;
  };
  if (joint.lower) lines.emplace_back("lower", toml(clear(*joint.lower, -1.0)));
  if (joint.upper) lines.emplace_back("upper", toml(clear(*joint.upper, 1.0)));
  lines.emplace_back("stiffness", toml(inertia * joint.stop_frequency * joint.stop_frequency));
  lines.emplace_back("damping", toml(2.0 * joint.stop_damping_ratio * inertia * joint.stop_frequency));
  add("force", name + "_stop", comments, lines);
}

void Writer::add_forces_in_all_directions(std::size_t j) {
  const Joint& joint = tree_.joints[j];
  const std::string& name = joint_names_[j];
  const bool slides = joint.kind == JointKind::free;
  const std::string to = body(joint.child) + "." + name;
  std::string from = body(joint.parent) + "." + name;
  if (joint.friction > 0.0)
    findings_.note(
        "frictions left out",
        fmt::format(
            "joint \"{}\": friction is taken over for joints of one coordinate only; this one runs without",
            shown(joint.name)));
  if (joint.stiffness > 0.0 || joint.damping > 0.0) {
    if (!(joint.X_FM.R - Matrix3d::Identity()).isZero(0.0) || !joint.X_FM.p.isZero(0.0))
      from = marker(joint.parent, name + "_rest", joint.X_PF * joint.X_FM);
    std::vector<Line> lines = {text_line("type", "bushing"), text_line("from", from), text_line("to", to)};
    const auto three = [](double x) { return toml(Vector3d(Vector3d::Constant(x))); };
    if (joint.stiffness > 0.0) lines.emplace_back("rotational_stiffness", three(joint.stiffness));
    if (joint.damping > 0.0) lines.emplace_back("rotational_damping", three(joint.damping));
    if (slides && joint.stiffness > 0.0) lines.emplace_back("stiffness", three(joint.stiffness));
    if (slides && joint.damping > 0.0) lines.emplace_back("damping", three(joint.damping));
    add("force", name + "_spring", {}, lines);
  }
  if (!(joint.armature > 0.0)) return;
  const auto resist = [&](const char* measure, const char* element) {
    std::vector<Line> lines = {text_line("type", element), text_line("marker", to), text_line("axes", from)};
    if (joint.parent >= 0) lines.push_back(text_line("reaction", from));
    for (int k = 0; k < 3; ++k) {
      const std::string axis(1, "xyz"[k]);
      const std::string m = add("measure", fmt::format("{}_{}_{}", name, measure, axis), {},
                                {text_line("type", measure),
                                 text_line("from", from),
                                 text_line("to", to),
                                 {"direction", toml(Vector3d(Vector3d::Unit(k)))}});
      lines.push_back(text_line(axis, fmt::format("-{} * {}", toml(joint.armature), m)));
    }
    add("force", fmt::format("{}_{}_armature", name, element), {"the armature's inertia"}, lines);
  };
  resist("angular_acceleration", "torque");
  if (slides) resist("acceleration", "force");
}

std::string Writer::add_rotor_body(const std::string& wanted, double size) {
  if (!has_rotors_) result_.ground.push_back({"rotors", {}});
  has_rotors_ = true;
  Body rotor;
  rotor.name = names_.add(wanted);
  rotor.comments = {
      "inertia along a coordinate alone, as of a motor behind a gear: a wheel on the ground that turns with "
      "it"};
  rotor.inertia = size * Matrix3d::Identity();
  rotor.markers.push_back({"axis", {}});
  const std::string joint = names_.add(wanted + "_turn");
  result_.elements.push_back({"joint",
                              joint,
                              {},
                              {text_line("type", "revolute"), text_line("from", "ground.rotors"),
                               text_line("to", rotor.name + ".axis")}});
  result_.bodies.push_back(std::move(rotor));
  return joint;
}

void Writer::add_rotor(const std::string& wanted, double size,
                       const std::vector<std::pair<int, double>>& sum) {
  const std::string turn = add_rotor_body(wanted, size);
  std::string joints = "[" + toml(turn), factors = "[-1.0";
  for (const auto& [j, factor] : sum) {
    joints += ", " + toml(joint(j));
    factors += ", " + toml(factor);
  }
  add("constraint", wanted + "_gear", {},
      {text_line("type", "coupler"), {"joints", joints + "]"}, {"factors", factors + "]"}});
}

void Writer::add_rotor_along(const std::string& wanted, double size, const std::string& formula) {
  const std::string turn = add_rotor_body(wanted, size);
  add("constraint", wanted + "_gear", {},
      {text_line("type", "expression"), text_line("value", fmt::format("{} - {}.angle", formula, turn))});
}

}  // namespace flexura::import::tree
