// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/mjcf/joints.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "import/xml/values.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::mjcf {
namespace {

using tree::JointKind;

// Newer files have polynomials; their first number is the constant part.
double first_number(const Node& e, const char* attribute, Findings& findings) {
  const std::vector<double> values = xml::numbers(e, attribute, findings);
  for (std::size_t k = 1; k < values.size(); ++k)
    if (values[k] != 0.0) {
      xml::note(findings, e, "values of joints left out",
                fmt::format("of the {} only the first number is taken over, {}: the others make it "
                            "depend on the coordinate",
                            attribute, values[0]));
      break;
    }
  return values.empty() ? 0.0 : values[0];
}

}  // namespace

std::pair<double, double> stop_law(const std::vector<double>& solref) {
  const double time = solref.empty() ? 0.02 : solref[0], ratio = solref.size() < 2 ? 1.0 : solref[1];
  if (time > 0.0 && ratio > 0.0) return {1.0 / (time * ratio), ratio};
  // Both negative: stiffness and damping of a unit inertia.
  const double omega = std::sqrt(std::max(-time, 1e-6));
  return {omega, std::max(-ratio, 0.0) / (2.0 * omega)};
}

bool is_limited(const Node& element, const char* limited, const char* range, const Compiler& compiler,
                Findings& findings) {
  if (element.get(limited, "auto") == "auto") return compiler.autolimits && element.has(range);
  return xml::flag(element, limited, false, findings);
}

BodyJoint read_joint(const Node& e, const Model& model, const Pose& X_BF, Findings& findings) {
  static const std::map<std::string, JointKind> kinds = {{"hinge", JointKind::revolute},
                                                         {"slide", JointKind::prismatic},
                                                         {"ball", JointKind::spherical},
                                                         {"free", JointKind::free}};
  BodyJoint result;
  tree::Joint& joint = result.joint;
  joint.name = e.get("name");
  joint.line = *e.file == findings.file() ? e.line : 0;
  const std::string type = e.tag == "freejoint" ? "free" : e.get("type", "hinge");
  const auto kind = kinds.find(type);
  if (kind == kinds.end()) {
    xml::fault(findings, e,
               fmt::format("<joint> is of the type \"{}\"; write hinge, slide, ball or free", shown(type)));
    return result;
  }
  joint.kind = kind->second;
  if (e.tag == "freejoint") return result;
  const bool turns = joint.kind == JointKind::revolute, one = joint.has_one_coordinate();
  const double unit = turns && model.compiler.degree ? std::numbers::pi / 180.0 : 1.0;
  Pose X_BM;
  if (joint.kind != JointKind::free) X_BM.p = X_BF * xml::vector(e, "pos", Vector3d::Zero(), findings);
  if (one) {
    Vector3d axis = X_BF.R * xml::vector(e, "axis", Vector3d::UnitZ(), findings);
    if (!(axis.norm() > 0.0)) {
      xml::fault(findings, e, "axis of <joint> has no length; give its direction");
      axis = Vector3d::UnitZ();
    }
    X_BM.R = mbs::frame_along(axis);
    joint.start = unit * xml::number(e, "ref", 0.0, findings);
  }
  joint.X_CM = joint.X_PF = X_BM;
  joint.rest = unit * xml::number(e, "springref", 0.0, findings);
  if (model.option.springs) joint.stiffness = first_number(e, "stiffness", findings);
  if (model.option.dampers) joint.damping = first_number(e, "damping", findings);
  if (model.option.friction) joint.friction = xml::number(e, "frictionloss", 0.0, findings);
  joint.armature = xml::number(e, "armature", 0.0, findings);
  for (const auto& [value, key] : {std::pair(joint.friction, "frictionloss"), {joint.armature, "armature"}})
    if (value < 0.0)
      xml::fault(findings, e,
                 fmt::format("{} of <joint> is {}, it cannot be negative; correct it", key, value));
  if (const std::vector<double> law = xml::numbers(e, "springdamper", findings); law.size() == 2) {
    result.info.spring_time = law[0];
    result.info.spring_damping_ratio = law[1];
  }
  if (model.option.limits && is_limited(e, "limited", "range", model.compiler, findings)) {
    const std::vector<double> range = xml::numbers(e, "range", findings);
    if (one && range.size() == 2 && range[0] < range[1]) {
      double margin = xml::number(e, "margin", 0.0, findings);
      if (2.0 * margin >= unit * (range[1] - range[0])) margin = 0.0;  // both stops would push at once
      joint.lower = unit * range[0] + margin;
      joint.upper = unit * range[1] - margin;
      std::tie(joint.stop_frequency, joint.stop_damping_ratio) =
          stop_law(xml::numbers(e, "solreflimit", findings));
    } else if (one) {
      xml::note(findings, e, "limits left out",
                fmt::format("joint \"{}\" is limited, but its range is \"{}\": it runs without a limit",
                            shown(joint.name), shown(e.get("range"))));
    } else if (joint.kind == JointKind::spherical) {
      xml::note(
          findings, e, "limits left out",
          fmt::format("the cone that limits the ball joint \"{}\" is not taken over", shown(joint.name)));
    }
  }
  if (is_limited(e, "actuatorfrclimited", "actuatorfrcrange", model.compiler, findings))
    if (const std::vector<double> range = xml::numbers(e, "actuatorfrcrange", findings); range.size() == 2)
      result.info.motor_limits = {range[0], range[1]};
  return result;
}

}  // namespace flexura::import::mjcf
