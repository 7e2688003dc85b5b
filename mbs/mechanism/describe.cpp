// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mbs/base/documents/document.hpp"
#include "mbs/kinematics/picture.hpp"

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
      {"energy.input", input::dim::energy, "work put in by applied forces and drives so far",
       OutputRole::energy},
      {"energy.dissipated", input::dim::energy, "energy taken out by dampers and impacts so far",
       OutputRole::energy},
      {"energy.balance", input::dim::energy,
       "kinetic + strain + potential, less their start and the work put in, plus what was dissipated: the "
       "error "
       "of the run",
       OutputRole::energy}};
  return infos;
}

// Dimensions do not tell a joule from a newton metre.
std::string unit_of(const OutputInfo& quantity) {
  const bool is_energy = quantity.dimension == input::dim::energy && quantity.role == OutputRole::energy;
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
  const auto numbers = [](const Vector3d& p) { return nlohmann::json{p.x(), p.y(), p.z()}; };
  const auto rotation = [&](int marker) {
    const Eigen::Quaterniond q(pose(marker).R);
    return nlohmann::json{q.w(), q.x(), q.y(), q.z()};
  };
  // What the element that was added last draws besides.
  const auto add_picture = [&](const HasPicture* picture, int marker_F) {
    if (!picture) return;
    nlohmann::json& j = list.back();
    if (const auto surface = picture->drawn_surface(); surface && marker_F >= 0) {
      j["surface"] = {{"kind", surface->kind},
                      {"radius", surface->radius},
                      {"closed", surface->is_closed},
                      {"touching", surface->touching},
                      {"rotation", rotation(marker_F)}};
      for (const Vector3d& p : surface->points) j["surface"]["points"].push_back(numbers(p));
    }
    if (const BodyPath* const path = picture->drawn_path()) {
      // Its force stands where the place is, in axes that no marker has where it is a constraint's.
      for (int i = 0; i < path->size(); ++i)
        j["path"].push_back({{"body", d.bodies[d.markers[path->marker(i)].body].name},
                             {"p", numbers(pose(path->marker(i)).p)},
                             {"place", path->place(i)}});
    }
  };
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
    if (from < 0 && to < 0) continue;
    add(force->name(), std::string(force->type()), from, to, force->axes());
    add_picture(dynamic_cast<const HasPicture*>(force.get()), from);
  }
  for (const auto& constraint : d.constraints) {
    const std::vector<int> markers = constraint->markers();
    if (markers.size() < 2) continue;
    const auto outputs = constraint->outputs();
    const bool is_link =
        std::ranges::any_of(outputs, [](const OutputInfo& o) { return o.name == "tension"; });
    const auto* const picture = dynamic_cast<const HasPicture*>(constraint.get());
    const bool has_path = picture && picture->drawn_path();
    add(constraint->name(),
        is_link    ? "link"
        : has_path ? "path"
                   : "constraint",
        markers.front(), markers.back(), markers.front());
    if (has_path) list.back().erase("axes");  // those of the path there: no marker has them
    add_picture(picture, markers.front());
  }
  for (std::size_t m = 0; m < d.markers.size(); ++m) {
    const int marker = static_cast<int>(m);
    const std::string& body = d.bodies[d.markers[m].body].name;
    // "crank.pin" is of the file; frames that the program itself puts in have no body in their names.
    if (d.markers[m].name.find('.') == std::string::npos) continue;
    list.push_back({{"name", d.markers[m].name},
                    {"kind", "marker"},
                    {"body_1", body},
                    {"p_1", numbers(pose(marker).p)},
                    {"rotation", rotation(marker)}});
  }
  return list.dump();
}

}  // namespace flexura::mbs
