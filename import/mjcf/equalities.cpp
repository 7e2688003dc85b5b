// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>

#include "import/mjcf/joints.hpp"
#include "import/mjcf/sections.hpp"
#include "import/xml/values.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::mjcf {
namespace {

Line text_line(const std::string& key, const std::string& value) {
  return {key, toml(value)};
}

class EqualityWriter {
 public:
  EqualityWriter(const Scene& scene, const Tendons& tendons, tree::Writer& writer, Findings& findings)
      : scene_(scene),
        tendons_(tendons),
        writer_(writer),
        findings_(findings),
        X_WL_(tree::start_poses(scene.tree)) {}

  void add(const Node& e, const Scope& scope) {
    if (!xml::flag(e, "active", true, findings_)) {
      xml::note(findings_, e, "equalities that are not active",
                fmt::format("<{}> \"{}\" is not active and left out", e.tag, shown(e.get("name"))));
      return;
    }
    ++n_;
    if (e.tag == "connect" || e.tag == "weld")
      add_bond(e, scope);
    else if (e.tag == "joint")
      add_joints(e, scope);
    else if (e.tag == "tendon")
      add_tendons(e, scope);
    else if (e.tag == "distance")
      xml::note(findings_, e, "equalities left out",
                "<distance> between geoms' surfaces is left out: the mechanism file has none");
    else
      xml::note(findings_, e, "equalities left out",
                fmt::format("<{}> is left out: the mechanism file has none", shown(e.tag)));
  }

 private:
  std::string name_of(const Node& e, const Scope& scope) const {
    return e.has("name") ? scope.full(e.get("name")) : fmt::format("{}_{}", e.tag, n_);
  }

  Pose X_W(const Place& place) const {
    return place.link < 0 ? place.X_LP : X_WL_[static_cast<std::size_t>(place.link)] * place.X_LP;
  }

  // The link that it stands still in.
  int carrier(int link) const {
    for (const tree::Joint& joint : scene_.tree.joints)
      if (joint.child == link && joint.kind == tree::JointKind::fixed) return carrier(joint.parent);
    return link;
  }

  void add_bond(const Node& e, const Scope& scope) {
    const std::string name = name_of(e, scope);
    Place a, b;
    if (e.has("site1") || e.has("site2")) {
      const Place* const sites[] = {find(scene_.sites, scope, e.get("site1")),
                                    find(scene_.sites, scope, e.get("site2"))};
      if (sites[0] == nullptr || sites[1] == nullptr) return;  // a fault already
      a = *sites[0];
      b = *sites[1];
    } else {
      const int* const first = find(scene_.bodies, scope, e.get("body1"));
      const int* const second = find(scene_.bodies, scope, e.get("body2", "world"));
      if (first == nullptr || second == nullptr) return;
      a.link = *first;
      b.link = *second;
      const Vector3d anchor = xml::vector(e, "anchor", Vector3d::Zero(), findings_);
      const Pose X_ab = X_W(a).inverse() * X_W(b);
      if (e.tag == "connect") {
        a.X_LP.p = anchor;
        b.X_LP = X_ab.inverse() * a.X_LP;
      } else {
        b.X_LP.p = anchor;
        std::vector<double> pose = xml::numbers(e, "relpose", findings_);
        const bool given =
            pose.size() == 7 && (pose[3] != 0.0 || pose[4] != 0.0 || pose[5] != 0.0 || pose[6] != 0.0);
        const Pose X =
            given ? Pose{mbs::rotation_of_quaternion(&pose[3]), {pose[0], pose[1], pose[2]}} : X_ab;
        a.X_LP = X * b.X_LP;
      }
    }
    if (carrier(a.link) == carrier(b.link)) {
      xml::note(findings_, e, "equalities left out",
                fmt::format("{} \"{}\" holds two bodies that do not move against each other and is left out",
                            e.tag, shown(name)));
      return;
    }
    const bool points_only = e.tag == "connect" || xml::number(e, "torquescale", 1.0, findings_) == 0.0;
    const double open = (X_W(a).p - X_W(b).p).norm();
    if (open > 1e-6 && points_only) return pull_together(e, name, a, b, open);
    if (open > 1e-6)
      xml::note(findings_, e, "loops open at the start",
                fmt::format("{} \"{}\" is open by {:.3g} m at the start and is closed before it runs", e.tag,
                            shown(name), open));
    writer_.add("joint", name, {"rigid here; MuJoCo's gives way a little"},
                {text_line("type", points_only ? "spherical" : "fixed"),
                 text_line("from", writer_.marker(a.link, name + "_1", a.X_LP)),
                 text_line("to", writer_.marker(b.link, name + "_2", b.X_LP)),
                 {"cut", "true"}});
  }

  // As MuJoCo does: a spring and a damper of its time constant, for what the points carry at the start.  A joint would have to
  // close before the motion, and the bodies would start elsewhere than the file puts them.
  void pull_together(const Node& e, const std::string& name, const Place& a, const Place& b, double open) {
    double compliance = 0.0;
    for (int k = 0; k < 3; ++k) {
      tree::StartMass::Row row = writer_.mass().moves(b.link, X_W(b).p, Vector3d::Unit(k));
      for (const auto& [c, f] : writer_.mass().moves(a.link, X_W(a).p, Vector3d::Unit(k)))
        row.emplace_back(c, -f);
      compliance += writer_.mass().compliance(row) / 3.0;
    }
    if (!(compliance > 0.0)) return;
    const auto [omega, ratio] = stop_law(xml::numbers(e, "solref", findings_));
    const auto three = [](double x) { return toml(Vector3d(Vector3d::Constant(x))); };
    xml::note(
        findings_, e, "loops open at the start",
        fmt::format(
            "{} \"{}\" is open by {:.3g} m at the start: a spring with MuJoCo's time constant closes it",
            e.tag, shown(name), open));
    writer_.add("force", name, {"open at the start in the file"},
                {text_line("type", "bushing"),
                 text_line("from", writer_.marker(a.link, name + "_1", a.X_LP)),
                 text_line("to", writer_.marker(b.link, name + "_2", b.X_LP)),
                 {"stiffness", three(omega * omega / compliance)},
                 {"damping", three(2.0 * ratio * omega / compliance)}});
  }

  std::vector<double> polynomial(const Node& e) const {
    std::vector<double> c = xml::numbers(e, "polycoef", findings_);
    if (c.empty()) c = {0.0, 1.0};
    c.resize(5, 0.0);
    return c;
  }

  // y - y_0 = c_0 + c_1 (x - x_0) + ...
  void add_law(const std::string& name, const std::string& y, double y_0, const std::string& x, double x_0,
               const std::vector<double>& c) {
    const auto less = [](const std::string& q, double q_0) {
      return q_0 == 0.0 ? q : fmt::format("({} - ({}))", q, toml(q_0));
    };
    std::string value = fmt::format("{} - ({})", less(y, y_0), toml(c[0]));
    for (std::size_t k = 1; k < c.size() && !x.empty(); ++k)
      if (c[k] != 0.0)
        value += fmt::format(" - ({}) * {}{}", toml(c[k]), less(x, x_0), k > 1 ? fmt::format("^{}", k) : "");
    writer_.add("constraint", name, {}, {text_line("type", "expression"), text_line("value", value)});
  }

  void add_joints(const Node& e, const Scope& scope) {
    const int* const first = find(scene_.joints, scope, e.get("joint1"));
    const int* const second = e.has("joint2") ? find(scene_.joints, scope, e.get("joint2")) : nullptr;
    if (first == nullptr || (e.has("joint2") && second == nullptr)) return;
    const auto joint = [&](int j) -> const tree::Joint& {
      return scene_.tree.joints[static_cast<std::size_t>(j)];
    };
    if (!joint(*first).has_one_coordinate() || (second != nullptr && !joint(*second).has_one_coordinate())) {
      xml::fault(findings_, e,
                 fmt::format("<joint> couples joints that are no hinges or slides; correct the names"));
      return;
    }
    const std::vector<double> c = polynomial(e);
    const double y_0 = joint(*first).start, x_0 = second == nullptr ? 0.0 : joint(*second).start;
    if (second != nullptr && (c[2] != 0.0 || c[3] != 0.0 || c[4] != 0.0)) {
      add_law(name_of(e, scope), writer_.coordinate(*first), y_0, writer_.coordinate(*second), x_0, c);
      return;
    }
    std::string joints = "[" + toml(writer_.joint(*first)), factors = "[1.0";
    if (second != nullptr && c[1] != 0.0) {
      joints += ", " + toml(writer_.joint(*second));
      factors += ", " + toml(-c[1]);
    }
    writer_.add("constraint", name_of(e, scope), {},
                {text_line("type", "coupler"),
                 {"joints", joints + "]"},
                 {"factors", factors + "]"},
                 {"offset", toml(y_0 + c[0] - (second == nullptr ? 0.0 : c[1] * x_0))}});
  }

  void add_tendons(const Node& e, const Scope& scope) {
    const TendonNames* const first = find(tendons_, scope, e.get("tendon1"));
    const TendonNames* const second = e.has("tendon2") ? find(tendons_, scope, e.get("tendon2")) : nullptr;
    if (first == nullptr || (e.has("tendon2") && second == nullptr)) {
      xml::note(findings_, e, "equalities left out",
                "the equality of tendons is left out: one of them is not taken over");
      return;
    }
    add_law(name_of(e, scope), first->length, first->start_length, second == nullptr ? "" : second->length,
            second == nullptr ? 0.0 : second->start_length, polynomial(e));
  }

  const Scene& scene_;
  const Tendons& tendons_;
  tree::Writer& writer_;
  Findings& findings_;
  std::vector<Pose> X_WL_;
  int n_ = 0;
};

}  // namespace

void add_equalities(const Scene& scene, const Tendons& tendons, tree::Writer& writer, Findings& findings) {
  EqualityWriter equalities(scene, tendons, writer, findings);
  std::vector<const Model*> models;
  for (const Scope& scope : scene.scopes)
    if (std::ranges::find(models, scope.model) == models.end()) models.push_back(scope.model);
  const auto body = [&](const std::string& n) { return scene.bodies.contains(n); };
  const auto joint = [&](const std::string& n) { return scene.joints.contains(n); };
  const auto site = [&](const std::string& n) { return scene.sites.contains(n); };
  for (const Model* model : models)
    for (const Node* section : model->sections("equality"))
      for (const Node& e : section->children) {
        std::vector<Reference> references;
        for (const char* key : {"body1", "body2"})
          if (e.has(key)) references.emplace_back(body, e.get(key));
        for (const char* key : {"joint1", "joint2"})
          if (e.has(key)) references.emplace_back(joint, e.get(key));
        for (const char* key : {"site1", "site2"})
          if (e.has(key)) references.emplace_back(site, e.get(key));
        for (const Scope& scope : copies_of(e, *model, scene, references, findings)) {
          Node full = e;
          full.tag = "equality";
          full = model->defaults.applied(full, "", findings);
          full.tag = e.tag;
          equalities.add(full, scope);
        }
      }
}

}  // namespace flexura::import::mjcf
