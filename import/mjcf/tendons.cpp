// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>

#include "import/mjcf/joints.hpp"
#include "import/mjcf/sections.hpp"
#include "import/xml/values.hpp"

namespace flexura::import::mjcf {
namespace {

Line text_line(const std::string& key, const std::string& value) {
  return {key, toml(value)};
}

class TendonWriter {
 public:
  TendonWriter(const Scene& scene, tree::Writer& writer, Findings& findings)
      : scene_(scene), writer_(writer), findings_(findings), X_WL_(tree::start_poses(scene.tree)) {
    tree::Tree at_rest = scene.tree;
    for (tree::Joint& joint : at_rest.joints) joint.start = joint.rest;
    X_WL_rest_ = tree::start_poses(at_rest);
  }

  void add(const Node& e, const Model& model, const Scope& scope) {
    const std::string name = scope.full(e.get("name", "tendon"));
    TendonNames tendon;
    start_length_ = rest_length_ = 0.0;
    row_.clear();
    const bool known = e.tag == "fixed" ? add_joints(e, scope, tendon) : add_segments(e, scope, name, tendon);
    if (!known) {
      if (acts(e) || !e.get("name").empty())
        xml::note(
            findings_, e, "tendons left out",
            fmt::format("tendon \"{}\" wraps round a geom, which the mechanism file has no element for: {}",
                        shown(name), acts(e) ? "its forces are left out" : "it is left out"));
      return;
    }
    name_length(name, tendon);
    add_forces(e, model, name, tendon);
    tendons_[name] = tendon;
  }
  Tendons take() { return std::move(tendons_); }

 private:
  bool acts(const Node& e) const {
    Findings none({});
    for (const char* key : {"stiffness", "damping", "frictionloss", "armature"})
      for (const double x : xml::numbers(e, key, none))
        if (x != 0.0) return true;
    return e.has("range");
  }

  bool add_joints(const Node& e, const Scope& scope, TendonNames& tendon) {
    for (const Node* part : e.all("joint")) {
      const int* j = find(scene_.joints, scope, part->get("joint"));
      if (j == nullptr || !scene_.tree.joints[static_cast<std::size_t>(*j)].has_one_coordinate()) {
        xml::fault(findings_, *part,
                   fmt::format(
                       "tendon \"{}\" names joint \"{}\", which is no hinge or slide of the file; correct it",
                       shown(e.get("name")), shown(part->get("joint"))));
        continue;
      }
      const tree::Joint& joint = scene_.tree.joints[static_cast<std::size_t>(*j)];
      const double coef = xml::number(*part, "coef", 1.0, findings_);
      tendon.joints.emplace_back(*j, coef);
      row_.emplace_back(writer_.mass().first(*j), coef);
      start_length_ += coef * joint.start;
      rest_length_ += coef * joint.rest;
    }
    return true;
  }

  // Straight between sites; a pulley divides what follows it.
  bool add_segments(const Node& e, const Scope& scope, const std::string& name, TendonNames& tendon) {
    double divisor = 1.0;
    std::optional<Place> before;
    std::string from;
    if (e.child("geom") != nullptr) return false;
    for (const Node& part : e.children) {
      if (part.tag == "pulley") {
        divisor = xml::number(part, "divisor", 1.0, findings_);
        if (!(divisor > 0.0)) {
          xml::fault(findings_, part, fmt::format("divisor of <pulley> is {}, it must be positive", divisor));
          divisor = 1.0;
        }
        before.reset();
      }
      if (part.tag != "site") continue;
      const Place* site = find(scene_.sites, scope, part.get("site"));
      if (site == nullptr) {
        xml::fault(findings_, part,
                   fmt::format("tendon \"{}\" names site \"{}\", which the file does not have; correct it",
                               shown(e.get("name")), shown(part.get("site"))));
        continue;
      }
      const std::string marker = writer_.marker(site->link, name + "_" + part.get("site"), site->X_LP);
      if (before && before->link != site->link) {
        tendon.segments.push_back({from, marker, 1.0 / divisor, ""});
        const Vector3d a = at(*before, X_WL_), b = at(*site, X_WL_);
        const double length = (b - a).norm();
        start_length_ += length / divisor;
        rest_length_ += (at(*site, X_WL_rest_) - at(*before, X_WL_rest_)).norm() / divisor;
        if (length > 0.0) {
          for (const auto& [c, f] : writer_.mass().moves(site->link, b, (b - a) / length))
            row_.emplace_back(c, f / divisor);
          for (const auto& [c, f] : writer_.mass().moves(before->link, a, (a - b) / length))
            row_.emplace_back(c, f / divisor);
        }
      } else if (before) {  // both on one body: of constant length
        constant_ += (site->X_LP.p - before->X_LP.p).norm() / divisor;
      }
      before = *site;
      from = marker;
    }
    return true;
  }

  static Vector3d at(const Place& place, const std::vector<Pose>& X_WL) {
    return place.link < 0 ? place.X_LP.p : X_WL[static_cast<std::size_t>(place.link)] * place.X_LP.p;
  }

  void name_length(const std::string& name, TendonNames& tendon) {
    std::vector<std::pair<double, std::string>> length, rate;
    for (const auto& [j, coef] : tendon.joints) {
      length.emplace_back(coef, writer_.coordinate(j));
      rate.emplace_back(coef, writer_.speed(j));
    }
    for (TendonNames::Segment& s : tendon.segments) {
      const auto measure = [&](const char* type) {
        return writer_.add("measure", fmt::format("{}_{}", name, type), {},
                           {text_line("type", type), text_line("from", s.from), text_line("to", s.to)});
      };
      s.length = measure("distance");
      length.emplace_back(s.factor, s.length);
      rate.emplace_back(s.factor, measure("distance_rate"));
    }
    if (constant_ != 0.0) length.emplace_back(constant_, "1.0");
    start_length_ += constant_;
    rest_length_ += constant_;
    constant_ = 0.0;
    tendon.start_length = start_length_;
    tendon.row = row_;
    tendon.length = writer_.add("measure", name + "_length", {},
                                {text_line("type", "expression"), text_line("value", sum_of(length))});
    tendon.rate = writer_.add("measure", name + "_rate", {},
                              {text_line("type", "expression"), text_line("value", sum_of(rate))});
  }

  void add_forces(const Node& e, const Model& model, const std::string& name, const TendonNames& tendon) {
    const auto first = [&](const char* key) {
      const std::vector<double> x = xml::numbers(e, key, findings_);
      return x.empty() ? 0.0 : x[0];
    };
    const double k = model.option.springs ? first("stiffness") : 0.0,
                 d = model.option.dampers ? first("damping") : 0.0;
    std::string force;
    if (k != 0.0) {
      std::vector<double> rest = xml::numbers(e, "springlength", findings_);
      // -1, and no other negative length, stands for that at the joints' own rest.
      if (rest.empty() || std::ranges::all_of(rest, [](double x) { return x == -1.0; }))
        rest = {rest_length_};
      if (rest.size() == 2 && rest[0] != rest[1])  // slack between the two
        force = fmt::format("-{} * (max(0.0, {} - {}) + min(0.0, {} - {}))", toml(k), tendon.length,
                            toml(rest[1]), tendon.length, toml(rest[0]));
      else
        force = fmt::format("-{} * ({} - {})", toml(k), tendon.length, toml(rest[0]));
    }
    if (d != 0.0) force += fmt::format("{}-{} * {}", force.empty() ? "" : " + ", toml(d), tendon.rate);
    if (!force.empty()) add_tendon_force(tendon, name + "_spring", force, writer_);
    if (const double f = model.option.friction ? first("frictionloss") : 0.0; f > 0.0)
      add_tendon_force(tendon, name + "_friction",
                       fmt::format("-{} * tanh({} / 0.001)", toml(f), tendon.rate), writer_);
    if (const double a = first("armature"); a > 0.0) {
      if (tendon.segments.empty())
        writer_.add_rotor(name + "_rotor", a, tendon.joints);
      else
        writer_.add_rotor_along(name + "_rotor", a, tendon.length);
    }
    if (!model.option.limits || !is_limited(e, "limited", "range", model.compiler, findings_)) return;
    const std::vector<double> range = xml::numbers(e, "range", findings_);
    const double compliance = writer_.mass().compliance(row_);
    if (range.size() != 2 || !(range[0] < range[1]) || !(compliance > 0.0)) return;
    const auto [omega, ratio] = stop_law(xml::numbers(e, "solreflimit", findings_));
    const double stiffness = omega * omega / compliance, damping = 2.0 * ratio * omega / compliance;
    const double margin = xml::number(e, "margin", 0.0, findings_);
    // A stop pushes and never pulls.
    const auto past = [&](double limit, const char* sign) {
      return fmt::format("({1}{0} > {1}({2}) ? max(0.0, {3} * {1}({0} - ({2})) + {4} * ({1}{5})) : 0.0)",
                         tendon.length, sign, toml(limit), toml(stiffness), toml(damping), tendon.rate);
    };
    add_tendon_force(tendon, name + "_stop",
                     past(range[0] + margin, "-") + " - " + past(range[1] - margin, ""), writer_);
  }

  const Scene& scene_;
  tree::Writer& writer_;
  Findings& findings_;
  std::vector<Pose> X_WL_, X_WL_rest_;  ///< at the start, and where joints' springs are without force
  Tendons tendons_;
  double start_length_ = 0.0, rest_length_ = 0.0, constant_ = 0.0;
  tree::StartMass::Row row_;
};

}  // namespace

std::string sum_of(const std::vector<std::pair<double, std::string>>& terms) {
  std::string sum;
  for (const auto& [factor, name] : terms) {
    if (factor == 0.0) continue;
    if (!sum.empty()) sum += factor < 0.0 ? " - " : " + ";
    const double shown_factor = sum.empty() ? factor : std::abs(factor);
    sum += shown_factor == 1.0 ? name : fmt::format("{} * {}", toml(shown_factor), name);
  }
  return sum.empty() ? "0.0" : sum;
}

void add_tendon_force(const TendonNames& tendon, const std::string& wanted, const std::string& formula,
                      tree::Writer& writer) {
  const auto times = [&](double factor) {
    return factor == 1.0 ? formula : fmt::format("{} * ({})", toml(factor), formula);
  };
  for (const auto& [j, factor] : tendon.joints)
    if (factor != 0.0)
      writer.add("force", wanted, {},
                 {text_line("type", "joint_force"), text_line("joint", writer.joint(j)),
                  text_line("value", times(factor))});
  for (const TendonNames::Segment& s : tendon.segments)
    writer.add("force", wanted, {},
               {text_line("type", "line_force"), text_line("from", s.from), text_line("to", s.to),
                text_line("value", times(s.factor))});
}

Tendons add_tendons(const Scene& scene, tree::Writer& writer, Findings& findings) {
  TendonWriter tendons(scene, writer, findings);
  std::vector<const Model*> models;
  for (const Scope& scope : scene.scopes)
    if (std::ranges::find(models, scope.model) == models.end()) models.push_back(scope.model);
  for (const Model* model : models)
    for (const Node* section : model->sections("tendon"))
      for (const Node& e : section->children) {
        if (e.tag != "spatial" && e.tag != "fixed") continue;
        std::vector<Reference> references;
        for (const Node& part : e.children) {
          if (part.tag == "joint")
            references.emplace_back([&](const std::string& n) { return scene.joints.contains(n); },
                                    part.get("joint"));
          if (part.tag == "site")
            references.emplace_back([&](const std::string& n) { return scene.sites.contains(n); },
                                    part.get("site"));
        }
        for (const Scope& scope : copies_of(e, *model, scene, references, findings))
          tendons.add(model->defaults.applied(e, "", findings), *model, scope);
      }
  return tendons.take();
}

}  // namespace flexura::import::mjcf
