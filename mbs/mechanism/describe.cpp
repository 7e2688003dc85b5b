// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mbs/base/documents/document.hpp"

namespace flexura::mbs {
namespace {

bool fits(const char* pattern, const char* text) {
  if (*pattern == '\0') return *text == '\0';
  if (*pattern == '*') return fits(pattern + 1, text) || (*text != '\0' && fits(pattern, text + 1));
  return *text != '\0' && (*pattern == '?' || *pattern == *text) && fits(pattern + 1, text + 1);
}

}  // namespace

const std::vector<OutputInfo>& run_quantities() {
  static const std::vector<OutputInfo> infos = {
      {"energy.input", input::dim::energy, "work put in by applied forces and drives so far"},
      {"energy.dissipated", input::dim::energy, "energy taken out by dampers and impacts so far"},
      {"energy.balance", input::dim::energy,
       "kinetic + strain + potential, less their start and the work put in, plus what was dissipated: the "
       "error "
       "of the run"}};
  return infos;
}

// Dimensions do not tell a joule from a newton metre; list_quantities() and run_quantities() give energies these names.
std::string unit_of(const OutputInfo& quantity) {
  const bool is_energy = quantity.dimension == input::dim::energy &&
                         (quantity.name.starts_with("energy.") || quantity.name.ends_with(".strain_energy"));
  return is_energy ? "J" : input::si_unit(quantity.dimension);
}

std::vector<int> select_quantities(const Mechanism& mechanism, const std::vector<std::string>& patterns) {
  if (patterns.empty()) return mechanism.usual_quantities();
  const std::vector<OutputInfo> infos = mechanism.quantities();
  std::vector<int> which;
  for (const std::string& pattern : patterns) {
    bool any = false;
    for (std::size_t i = 0; i < infos.size(); ++i) {
      if (!fits(pattern.c_str(), infos[i].name.c_str())) continue;
      any = true;
      if (std::ranges::find(which, static_cast<int>(i)) == which.end()) which.push_back(static_cast<int>(i));
    }
    std::vector<std::string> known;
    for (const OutputInfo& info : run_quantities()) {
      any = any || fits(pattern.c_str(), info.name.c_str());
      known.push_back(info.name);
    }
    if (any) continue;
    for (const OutputInfo& info : infos) known.push_back(info.name);
    const std::string near = input::nearest(pattern, known);
    throw std::invalid_argument(
        fmt::format("there is no quantity \"{}\"{}", pattern,
                    near.empty() ? "; flexura check lists all of them" : ", did you mean \"" + near + "\"?"));
  }
  return which;
}

std::string connections_json(const Mechanism& mechanism) {
  const MechanismDescription& d = mechanism.description();
  nlohmann::json list = nlohmann::json::array();
  const auto pose = [&](int marker) { return d.undeformed(marker); };
  const auto add = [&](const std::string& name, const std::string& kind, int marker_1, int marker_2,
                       int axes) {
    nlohmann::json j{{"name", name}, {"kind", kind}};
    // The axes in which the quantities of this connection give force components.
    const Eigen::Quaterniond q(axes >= 0 ? pose(axes).R : Matrix3d(Matrix3d::Identity()));
    j["axes"] = {{"body", d.bodies[axes >= 0 ? d.markers[axes].body : 0].name},
                 {"rotation", {q.w(), q.x(), q.y(), q.z()}}};
    const auto side = [&](int marker, const char* body_key, const char* point_key) {
      if (marker < 0) return;
      const Pose X = pose(marker);
      j[body_key] = d.bodies[d.markers[marker].body].name;
      j[point_key] = {X.p.x(), X.p.y(), X.p.z()};
    };
    side(marker_1, "body_1", "p_1");
    side(marker_2, "body_2", "p_2");
    if (marker_1 >= 0) {
      const Vector3d z = pose(marker_1).R.col(2);
      j["axis_1"] = {z.x(), z.y(), z.z()};
    }
    list.push_back(std::move(j));
  };
  for (const JointDescription& joint : d.joints) {
    add(joint.name, std::string(joint.joint->type()), joint.marker_F, joint.marker_M, joint.marker_F);
    list.back()["is_joint"] = true;
  }
  for (const auto& force : d.forces) {
    const auto [from, to] = force->markers();
    if (from >= 0 || to >= 0) add(force->name(), std::string(force->type()), from, to, force->axes());
  }
  return list.dump();
}

}  // namespace flexura::mbs
