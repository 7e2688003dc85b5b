// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "import/mjcf/actuator_law.hpp"
#include "import/mjcf/sections.hpp"
#include "import/xml/values.hpp"

namespace flexura::import::mjcf {
namespace {

Line text_line(const std::string& key, const std::string& value) {
  return {key, toml(value)};
}

class ActuatorWriter {
 public:
  ActuatorWriter(const Scene& scene, const Tendons& tendons, tree::Writer& writer, Findings& findings)
      : scene_(scene), tendons_(tendons), writer_(writer), findings_(findings) {}

  void add(const Node& e, const Model& model, const Scope& scope) {
    const ActuatorLaw law = read_actuator(e, model, findings_);
    const std::string name = e.has("name") ? scope.full(e.get("name")) : fmt::format("{}_{}", e.tag, ++n_);
    if (!law.unknown.empty()) {
      xml::note(findings_, e, "actuators left out",
                fmt::format("actuator \"{}\" is left out: {}", shown(name), law.unknown));
      return;
    }
    const std::string joint = e.get("joint", e.get("jointinparent"));
    if (!joint.empty()) {
      const int* j = find(scene_.joints, scope, joint);
      if (j == nullptr) return;  // a fault already
      const tree::JointKind kind = scene_.tree.joints[static_cast<std::size_t>(*j)].kind;
      if (scene_.tree.joints[static_cast<std::size_t>(*j)].has_one_coordinate())
        on_coordinate(e, law, name, *j);
      else
        on_marker(e, law, name, kind == tree::JointKind::free, ends_of(*j, e.has("jointinparent")));
    } else if (e.has("tendon")) {
      on_tendon(e, law, name, find(tendons_, scope, e.get("tendon")));
    } else if (e.has("site")) {
      on_site(e, law, name, scope);
    } else {
      xml::note(
          findings_, e, "actuators left out",
          fmt::format(
              "actuator \"{}\" is left out: it acts through {}, which the mechanism file has no element for",
              shown(name), e.has("body") ? "contacts" : "a slider-crank"));
    }
  }

  void finish() {
    for (const auto& [j, forces] : clamped_) {
      const auto& [lowest, highest] = *scene_.joint_infos.at(j).motor_limits;
      std::string sum;
      for (const std::string& f : forces) sum += (sum.empty() ? "" : " + ") + f;
      add_joint_force(j, writer_.joint(j) + "_motor",
                      fmt::format("max({}, min({}, {}))", toml(lowest), toml(highest), sum));
    }
  }

 private:
  // Where a force on a joint of several freedoms acts: on the body of the child, in axes of it or of the parent.
  struct Ends {
    std::string marker, axes, reaction;
  };

  void add_joint_force(int j, const std::string& wanted, const std::string& value) {
    writer_.add(
        "force", wanted, {},
        {text_line("type", "joint_force"), text_line("joint", writer_.joint(j)), text_line("value", value)});
  }

  std::string input(const Node& e, const ActuatorLaw& law, const std::string& name) {
    const std::string u =
        writer_.add("input", "u_" + name, {fmt::format("control of <{}> \"{}\"", e.tag, shown(name))},
                    {{"value", "0.0"}});
    std::string value = u;
    if (law.controls)
      value = fmt::format("max({}, min({}, {}))", toml(law.controls->first), toml(law.controls->second), u);
    if (law.activation == ActuatorLaw::Activation::none) return value;
    if (law.activation == ActuatorLaw::Activation::filter)
      return writer_.add(
          "control", name + "_act", {},
          {text_line("type", "filter"), text_line("input", value), {"time_constant", toml(law.time)}});
    return writer_.add("control", name + "_act", {}, {text_line("type", "state"), text_line("rate", value)});
  }

  std::string clamped(const ActuatorLaw& law, const std::string& force) const {
    return law.forces
               ? fmt::format("max({}, min({}, {}))", toml(law.forces->first), toml(law.forces->second), force)
               : force;
  }

  static std::vector<double> gear_of(const ActuatorLaw& law) {
    std::vector<double> gear = law.gear;
    gear.resize(6, 0.0);
    return gear;
  }

  void on_coordinate(const Node& e, const ActuatorLaw& law, const std::string& name, int j) {
    const double gear = gear_of(law)[0];
    if (gear == 0.0) return;
    // The inertia behind a gear is that of the joint, over its square (MuJoCo's set0).
    const ActuatorLaw own = law.with_damping(writer_.mass().carried(j) / (gear * gear));
    const std::string length = sum_of({{gear, writer_.coordinate(j)}}),
                      rate = sum_of({{gear, writer_.speed(j)}});
    const std::string force =
        sum_of({{gear, "(" + clamped(own, own.force(input(e, own, name), length, rate)) + ")"}});
    if (law.armature > 0.0) writer_.add_rotor(name + "_rotor", law.armature * gear * gear, {{j, 1.0}});
    if (scene_.joint_infos.at(j).motor_limits)
      clamped_[j].push_back(force);
    else
      add_joint_force(j, name, force);
  }

  void on_tendon(const Node& e, const ActuatorLaw& law, const std::string& name, const TendonNames* tendon) {
    if (tendon == nullptr) {
      xml::note(findings_, e, "actuators left out",
                fmt::format("actuator \"{}\" is left out: its tendon is not taken over", shown(name)));
      return;
    }
    const double gear = gear_of(law)[0];
    if (gear == 0.0) return;
    double inertia = 0.0;
    for (const auto& [coordinate, factor] : tendon->row)
      if (factor != 0.0) inertia += writer_.mass().diagonal(coordinate) / (gear * gear * factor * factor);
    const ActuatorLaw own = law.with_damping(inertia);
    const std::string force =
        sum_of({{gear, "(" +
                           clamped(own, own.force(input(e, own, name), sum_of({{gear, tendon->length}}),
                                                  sum_of({{gear, tendon->rate}}))) +
                           ")"}});
    add_tendon_force(*tendon, name, force, writer_);
  }

  Ends ends_of(int j, bool in_parent) {
    const tree::Joint& joint = scene_.tree.joints[static_cast<std::size_t>(j)];
    const std::string to = writer_.body(joint.child) + "." + writer_.joint(j),
                      from = writer_.body(joint.parent) + "." + writer_.joint(j);
    return {to, in_parent ? from : to, joint.parent < 0 ? "" : from};
  }

  // A wrench of gear times the force; of a free joint its force is in the world's axes.
  void on_marker(const Node& e, const ActuatorLaw& law, const std::string& name, bool slides,
                 const Ends& ends) {
    if (law.reads_motion()) {
      xml::note(
          findings_, e, "actuators left out",
          fmt::format("actuator \"{}\" is left out: it feeds back the motion of a joint or site of several "
                      "freedoms",
                      shown(name)));
      return;
    }
    const std::string force = "(" + clamped(law, law.force(input(e, law, name), "0.0", "0.0")) + ")";
    const std::vector<double> gear = gear_of(law);
    const auto add_element = [&](const char* type, std::size_t first, const std::string& axes) {
      std::vector<Line> lines = {text_line("type", type), text_line("marker", ends.marker)};
      if (!axes.empty()) lines.push_back(text_line("axes", axes));
      if (!ends.reaction.empty()) lines.push_back(text_line("reaction", ends.reaction));
      bool any = false;
      for (std::size_t k = 0; k < 3; ++k)
        if (gear[first + k] != 0.0) {
          lines.push_back(text_line(std::string(1, "xyz"[k]), sum_of({{gear[first + k], force}})));
          any = true;
        }
      if (any) writer_.add("force", name, {}, lines);
    };
    if (slides) add_element("force", 0, "");
    add_element("torque", slides ? 3 : 0, ends.axes);
  }

  void on_site(const Node& e, const ActuatorLaw& law, const std::string& name, const Scope& scope) {
    const Place* site = find(scene_.sites, scope, e.get("site"));
    if (site == nullptr) return;
    if (law.reads_motion() || e.has("refsite")) {
      xml::note(findings_, e, "actuators left out",
                fmt::format("actuator \"{}\" is left out: it feeds back the motion of a site", shown(name)));
      return;
    }
    const std::string force = "(" + clamped(law, law.force(input(e, law, name), "0.0", "0.0")) + ")";
    const std::vector<double> gear = gear_of(law);
    const std::string marker = writer_.marker(site->link, name + "_site", site->X_LP);
    for (std::size_t part = 0; part < 2; ++part) {
      std::vector<Line> lines = {text_line("type", part == 0 ? "force" : "torque"),
                                 text_line("marker", marker), text_line("axes", marker)};
      for (std::size_t k = 0; k < 3; ++k)
        if (gear[3 * part + k] != 0.0)
          lines.push_back(text_line(std::string(1, "xyz"[k]), sum_of({{gear[3 * part + k], force}})));
      if (lines.size() > 3) writer_.add("force", name, {}, lines);
    }
  }

  const Scene& scene_;
  const Tendons& tendons_;
  tree::Writer& writer_;
  Findings& findings_;
  std::map<int, std::vector<std::string>> clamped_;  ///< forces on joints that limit their sum
  int n_ = 0;
};

}  // namespace

void add_actuators(const Scene& scene, const Tendons& tendons, tree::Writer& writer, Findings& findings) {
  ActuatorWriter actuators(scene, tendons, writer, findings);
  std::vector<const Model*> models;
  for (const Scope& scope : scene.scopes)
    if (std::ranges::find(models, scope.model) == models.end()) models.push_back(scope.model);
  for (const Model* model : models)
    for (const Node* section : model->sections("actuator"))
      for (const Node& e : section->children) {
        std::vector<Reference> references;
        for (const char* key : {"joint", "jointinparent"})
          if (e.has(key))
            references.emplace_back([&](const std::string& n) { return scene.joints.contains(n); },
                                    e.get(key));
        for (const char* key : {"site", "refsite", "cranksite", "slidersite"})
          if (e.has(key))
            references.emplace_back([&](const std::string& n) { return scene.sites.contains(n); },
                                    e.get(key));
        for (const Scope& scope : copies_of(e, *model, scene, references, findings))
          actuators.add(e, *model, scope);
      }
  actuators.finish();
}

}  // namespace flexura::import::mjcf
