// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "import/urdf/read_elements.hpp"
#include "import/urdf/xml.hpp"

namespace flexura::import::urdf {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

JointKind read_kind(const Element& e, const std::string& name) {
  static const std::map<std::string, JointKind> kinds = {
      {"revolute", JointKind::revolute},   {"continuous", JointKind::continuous},
      {"prismatic", JointKind::prismatic}, {"fixed", JointKind::fixed},
      {"floating", JointKind::floating},   {"planar", JointKind::planar},
      {"spherical", JointKind::spherical}, {"ball", JointKind::spherical}};
  std::string type = e.text("type");
  for (char& c : type) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  const auto kind = kinds.find(type);
  if (kind == kinds.end())
    e.refuse(
        fmt::format("joint \"{}\" is of type \"{}\"; write revolute, continuous, prismatic, fixed, floating, "
                    "planar or spherical",
                    name, shown(e.text("type"))));
  return kind->second;
}

// A bound that is infinite, or no number: none.
double read_bound(const Element& limit, const char* attribute, double none, const std::string& joint,
                  Findings& findings) {
  if (!limit.has(attribute)) return 0.0;
  const std::string text = limit.text(attribute);
  if (const auto value = parse_number(text)) return *value;
  findings.repair("limits that are no finite numbers",
                  fmt::format("{} of joint \"{}\" is \"{}\": it has none", attribute, joint, shown(text)),
                  limit.line());
  return none;
}

// What bounds motors and speeds; 0: nothing.
double read_greatest(const Element& limit, const char* attribute, const std::string& joint,
                     Findings& findings) {
  if (!limit.has(attribute)) return 0.0;
  const std::string text = limit.text(attribute);
  const auto value = parse_number(text);
  if (value && *value > 0.0) return *value;
  if (!value || *value < 0.0)
    findings.note("efforts and speeds that are no bounds",
                  fmt::format("{} of joint \"{}\" is \"{}\": taken as none", attribute, joint, shown(text)),
                  limit.line());
  return 0.0;
}

std::optional<Limit> read_limit(const Element& e, const Joint& joint, const std::string& name,
                                Findings& findings) {
  const bool bounded = joint.kind == JointKind::revolute || joint.kind == JointKind::prismatic;
  const auto limit = e.child("limit");
  if (!limit) {
    if (bounded)
      findings.repair(
          "joints without a <limit>",
          fmt::format("joint \"{}\" has no <limit>, which a {} one needs: it moves without bounds", name,
                      e.text("type")),
          joint.line);
    return {};
  }
  Limit result{.lower = read_bound(*limit, "lower", -kNone, name, findings),
               .upper = read_bound(*limit, "upper", kNone, name, findings),
               .effort = read_greatest(*limit, "effort", name, findings),
               .velocity = read_greatest(*limit, "velocity", name, findings)};
  if (bounded && result.lower > result.upper) {
    findings.repair("limits that are exchanged",
                    fmt::format("lower {} of joint \"{}\" is above upper {}: exchanged", result.lower, name,
                                result.upper),
                    limit->line());
    std::swap(result.lower, result.upper);
  }
  return result;
}

void read_dynamics(const Element& e, bool one_way, const std::string& name, Joint& joint,
                   Findings& findings) {
  const auto dynamics = e.child("dynamics");
  if (!dynamics || joint.kind == JointKind::fixed) return;
  joint.damping = findings.kept([&] { return dynamics->number("damping", 0.0); });
  joint.friction = findings.kept([&] { return dynamics->number("friction", 0.0); });
  if (joint.damping < 0.0 || joint.friction < 0.0)
    findings.fault(fmt::format("damping {} and friction {} of joint \"{}\" cannot be negative; correct them",
                               joint.damping, joint.friction, name),
                   dynamics->line());
  if (!one_way && (joint.damping > 0.0 || joint.friction > 0.0))
    findings.note("joints of several coordinates with damping or friction",
                  fmt::format("joint \"{}\": damping and friction are taken over for joints of one "
                              "coordinate only; this one runs without",
                              name),
                  dynamics->line());
}

}  // namespace

Joint read_joint(const Element& e, const std::string& name, Findings& findings) {
  Joint joint;
  joint.line = e.line();
  joint.kind = findings.kept([&] { return read_kind(e, name); }, JointKind::fixed);
  joint.X_PJ = findings.kept([&] { return e.origin(); });
  const bool one_way = has_one_coordinate(joint), has_axis = one_way || joint.kind == JointKind::planar;
  if (const auto axis = e.child("axis"); axis && has_axis) {
    const Vector3d a =
        findings.kept([&] { return axis->vector("xyz", Vector3d::UnitX()); }, Vector3d::UnitX());
    if (a.norm() > 0.0)
      joint.axis = a.stableNormalized();
    else
      findings.fault(fmt::format("the axis of joint \"{}\" has no length; give its direction", name),
                     axis->line());
  }
  read_dynamics(e, one_way, name, joint, findings);
  if (one_way) joint.limit = read_limit(e, joint, name, findings);
  return joint;
}

}  // namespace flexura::import::urdf
