// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/mjcf/scene.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "import/mjcf/geoms.hpp"
#include "import/mjcf/joints.hpp"
#include "import/xml/values.hpp"

namespace flexura::import::mjcf {
namespace {

using tree::JointKind;

constexpr std::size_t kMostLinks = 20'000, kMostSolids = 200'000;
constexpr int kDeepest = 400;

/// Where the children of an element stand: in which link, at which place of it, of which class.
struct Spot {
  Scope scope;
  int link = -1;
  Pose X_LF;
  std::string child_class;
};

class Bodies {
 public:
  explicit Bodies(Findings& findings) : findings_(findings) {}

  Scene read(const Model& model) {
    scene_.scopes.push_back({&model, "", ""});
    scene_.bodies["world"] = -1;
    for (const Node* world : model.sections("worldbody"))
      read_children(*world, {scene_.scopes.front(), -1, {}, world->get("childclass")}, nullptr);
    if (scene_.tree.links.empty() && model.missing_include.empty()) add_still_body(model);
    scale_masses(model.compiler);
    for (const auto& [why, places] : open_) {
      std::string list;
      for (std::size_t i = 0; i < std::min<std::size_t>(places.size(), 3); ++i)
        list += (i > 0 ? ", " : "lines ") + places[i];
      findings_.fault(
          fmt::format("{}{}: {}, so the inertia of a body that moves is not known; give the body <inertial>",
                      list, places.size() > 3 ? fmt::format(" and {} more", places.size() - 3) : "", why));
    }
    return std::move(scene_);
  }

 private:
  // A mechanism has a body at least: of a scene in which nothing moves one that stands.
  void add_still_body(const Model& model) {
    bool any = !scene_.passed_over.empty();
    for (const Node* world : model.sections("worldbody"))
      for (const Node& e : world->children)
        any = any || e.tag == "geom" || e.tag == "site" || e.tag == "frame" || e.tag == "light";
    for (const Node* world : model.sections("worldbody"))
      for (const Node& e : world->children)
        if (e.tag == "flexcomp" || e.tag == "composite" || e.tag == "attach") any = false;
    if (!any) return;
    std::vector<BodyJoint> joints;
    Node scene;
    add_links(scene, "scene", -1, {}, joints);
    scene_.tree.links.back().comments = {"the file has no <body>: nothing moves"};
    findings_.note("models in which nothing moves", "the file has no <body>: nothing moves");
  }

  // What the geoms of a body add up to.
  struct Weight {
    tree::Inertial sum;
    std::vector<Matrix3d> axes;                             ///< of geoms with mass
    std::vector<std::pair<std::string, std::string>> open;  ///< (why, place)
  };

  void read_children(const Node& parent, const Spot& spot, Weight* weight) {
    if (++depth_ > kDeepest)
      throw std::invalid_argument(
          fmt::format("{}: bodies are nested more than {} deep", parent.place(), kDeepest));
    for (const Node& e : parent.children) {
      if (e.tag == "body")
        read_body(e, spot);
      else if (e.tag == "frame")
        read_children(e, inside(spot, e, pose_of(e, compiler(spot), findings_)), weight);
      else if (e.tag == "replicate")
        replicate(
            e, [&](const Spot& at) { read_children(e, at, weight); }, spot);
      else if (e.tag == "geom")
        read_geom_of(e, spot, weight);
      else if (e.tag == "site")
        read_site(e, spot);
      else if (e.tag == "attach")
        attach(e, spot, weight);
      else if (e.tag == "flexcomp" || e.tag == "composite")
        xml::fault(
            findings_, e,
            fmt::format("<{}> (\"{}\", type {}): bodies that deform, or are made by a rule, are not read",
                        e.tag, shown(e.get("name", e.get("prefix"))), shown(e.get("type", "none"))));
      else if (e.tag == "plugin" && weight != nullptr)
        xml::fault(findings_, e,
                   fmt::format("the forces of the plugin \"{}\" on this body are not known; take it away",
                               shown(e.get("plugin", e.get("instance")))));
      else if (e.tag != "joint" && e.tag != "freejoint" && e.tag != "inertial")
        ++scene_.passed_over[e.tag];
    }
    --depth_;
  }

  const Compiler& compiler(const Spot& spot) const { return spot.scope.model->compiler; }

  Spot inside(Spot spot, const Node& e, const Pose& X) const {
    spot.X_LF = spot.X_LF * X;
    spot.child_class = e.get("childclass", spot.child_class);
    return spot;
  }

  // Copies: each turned and moved from the one before, the first not (MuJoCo's xml_native_reader).
  void replicate(const Node& e, const std::function<void(const Spot&)>& visit, const Spot& spot) {
    const double count = xml::number(e, "count", 1.0, findings_);
    if (!(count >= 1.0) || count > 10'000.0) {
      xml::fault(findings_, e,
                 fmt::format("count of <replicate> is {}, 1 to 10000 are taken; correct it", count));
      return;
    }
    const Vector3d offset = xml::vector(e, "offset", Vector3d::Zero(), findings_),
                   euler = xml::vector(e, "euler", Vector3d::Zero(), findings_);
    const int n = static_cast<int>(count);
    const std::size_t digits = std::to_string(n).size();
    Vector3d at = Vector3d::Zero();
    for (int i = 0; i < n; ++i) {
      const Matrix3d R = rotation_by_euler(i * euler, compiler(spot));
      Spot copy = inside(spot, e, {R, at});
      at += R * offset;
      const std::string number = std::to_string(i);
      copy.scope.suffix =
          e.get("sep") + std::string(digits - number.size(), '0') + number + spot.scope.suffix;
      remember(copy.scope);
      visit(copy);
    }
  }

  void remember(const Scope& scope) {
    if (known_scopes_.insert(scope.prefix + "\n" + scope.suffix).second) scene_.scopes.push_back(scope);
  }

  void attach(const Node& e, const Spot& spot, Weight* weight) {
    const Model* child = spot.scope.model;
    if (e.has("model")) {
      const auto found = child->models.find(e.get("model"));
      if (found == child->models.end()) return;  // a fault already
      child = found->second.get();
    }
    Spot at = spot;
    at.scope = {child, spot.scope.prefix + e.get("prefix"), spot.scope.suffix};
    if (child != spot.scope.model) at.child_class.clear();
    remember(at.scope);
    const std::string wanted = e.has("body") ? "body" : e.has("frame") ? "frame" : "";
    const Node* subtree = nullptr;
    for (const Node* world : child->sections("worldbody")) {
      if (wanted.empty())
        read_children(*world, at, weight);
      else if (subtree == nullptr)
        subtree = named(*world, wanted, e.get(wanted));
    }
    if (wanted.empty()) return;
    if (subtree == nullptr)
      xml::fault(findings_, e,
                 fmt::format("there is no {} \"{}\" to be attached; correct the name", wanted,
                             shown(e.get(wanted))));
    else if (wanted == "body")
      read_body(*subtree, at);
    else
      read_children(*subtree, inside(at, *subtree, pose_of(*subtree, compiler(at), findings_)), weight);
  }

  static const Node* named(const Node& parent, const std::string& tag, const std::string& name) {
    for (const Node& e : parent.children) {
      if (e.tag == tag && e.get("name") == name) return &e;
      if (const Node* found = named(e, tag, name)) return found;
    }
    return nullptr;
  }

  // Of joints in frames of the body as well; the frames of other bodies are theirs.
  void collect_joints(const Node& parent, const Spot& spot, std::vector<BodyJoint>& joints) {
    for (const Node& e : parent.children) {
      if (e.tag == "frame")
        collect_joints(e, inside(spot, e, pose_of(e, compiler(spot), findings_)), joints);
      else if (e.tag == "replicate")
        replicate(
            e, [&](const Spot& at) { collect_joints(e, at, joints); }, spot);
      if (e.tag != "joint" && e.tag != "freejoint") continue;
      const Node full =
          e.tag == "joint" ? spot.scope.model->defaults.applied(e, spot.child_class, findings_) : e;
      joints.push_back(read_joint(full, *spot.scope.model, spot.X_LF, findings_));
      if (!joints.back().joint.name.empty())
        joints.back().joint.name = spot.scope.full(joints.back().joint.name);
    }
  }

  void read_body(const Node& e, const Spot& spot) {
    Spot own = spot;
    own.child_class = e.get("childclass", spot.child_class);
    Pose X_LB = spot.X_LF * pose_of(e, compiler(spot), findings_);
    if (compiler(spot).global)
      X_LB = global_from_.inverse() *
             (e.has("pos") || has_orientation(e) ? pose_of(e, compiler(spot), findings_) : global_from_);
    const Pose X_WB = global_from_ * X_LB;
    own.X_LF = compiler(spot).global ? X_WB.inverse() : Pose{};
    std::vector<BodyJoint> joints;
    collect_joints(e, own, joints);
    if (scene_.tree.links.size() + joints.size() > kMostLinks)
      throw std::invalid_argument(fmt::format("{}: there are more than {} bodies", e.place(), kMostLinks));
    const std::string given = e.get("name");
    const std::string name =
        given.empty() ? fmt::format("body_{}", scene_.tree.links.size() + 1) : spot.scope.full(given);
    own.link = add_links(e, name, spot.link, X_LB, joints);
    if (!given.empty() && !scene_.bodies.emplace(name, own.link).second)
      xml::fault(findings_, e, fmt::format("a second body \"{}\"; names must differ", shown(name)));
    scene_.gravity_compensation.back() = xml::number(e, "gravcomp", 0.0, findings_);
    if (xml::flag(e, "mocap", false, findings_))
      scene_.tree.links.back().comments.emplace_back("moved by hand in the file (mocap), it stands here");
    const bool moves = scene_.moves.back();
    const std::size_t link = scene_.tree.links.size() - 1;
    const Pose outer = std::exchange(global_from_, X_WB);
    Weight weight;
    read_children(e, own, &weight);
    global_from_ = outer;
    weigh(e, own, link, moves, weight);
  }

  // One link for each joint: those before the last have no mass.  Returns the last one.
  int add_links(const Node& e, const std::string& name, int parent, const Pose& X_LB,
                std::vector<BodyJoint>& joints) {
    tree::Tree& tree = scene_.tree;
    bool moves = parent >= 0 && scene_.moves[static_cast<std::size_t>(parent)];
    if (joints.empty()) {
      joints.emplace_back();
      joints.back().joint.name = name + "_fixed";
      joints.back().joint.line = e.line;
    }
    for (std::size_t i = 0; i < joints.size(); ++i) {
      tree::Joint& joint = joints[i].joint;
      if (joint.kind == JointKind::free && (joints.size() > 1 || parent >= 0))
        findings_.fault(
            fmt::format("the free joint of body \"{}\" must be the only one, of a body of the world; "
                        "take the others away",
                        shown(name)),
            joint.line);
      joint.parent = parent;
      joint.child = static_cast<int>(tree.links.size());
      const Pose X_PB = i == 0 ? X_LB : Pose{};
      if (joint.kind == JointKind::free) {
        joint.X_PF = {};
        joint.X_FM = X_PB;
      } else {
        tree::Joint reference = joint;  // F stands so that the coordinate is that of the file
        reference.start = -joint.start;
        joint.X_PF = X_PB * joint.X_PF * tree::start_motion(reference);
      }
      const std::string own = joint.name.empty()
                                  ? name + "_joint" + (joints.size() > 1 ? std::to_string(i + 1) : "")
                                  : joint.name;
      if (!joint.name.empty() && joint.kind != JointKind::fixed &&
          !scene_.joints.emplace(joint.name, static_cast<int>(tree.joints.size())).second)
        findings_.fault(fmt::format("a second joint \"{}\"; names must differ", shown(joint.name)),
                        joint.line);
      joint.name = own;
      const bool last = i + 1 == joints.size();
      moves = moves || joint.kind != JointKind::fixed;
      tree.links.push_back({.name = last ? name : fmt::format("{}_{}", name, i + 1)});
      if (!last) tree.links.back().comments.emplace_back("between two joints of one body");
      scene_.gravity_compensation.push_back(0.0);
      scene_.moves.push_back(moves);
      scene_.joint_infos[static_cast<int>(tree.joints.size())] = joints[i].info;
      parent = joint.child;
      tree.joints.push_back(joint);
    }
    return parent;
  }

  void read_geom_of(const Node& e, const Spot& spot, Weight* weight) {
    const Node geom = spot.scope.model->defaults.applied(e, spot.child_class, findings_);
    Geom read = read_geom(geom, *spot.scope.model, findings_);
    if (geom.has("name")) scene_.geoms[spot.scope.full(geom.get("name"))] = read.kind;
    if (xml::number(geom, "contype", 1.0, findings_) != 0.0 ||
        xml::number(geom, "conaffinity", 1.0, findings_) != 0.0)
      ++scene_.passed_over["contact"];
    if (geom.get("fluidshape") == "ellipsoid") scene_.ellipsoid_fluid.insert(spot.link);
    const double group = xml::number(geom, "group", 0.0, findings_);
    const Compiler& rules = compiler(spot);
    if (weight != nullptr && group >= rules.first_group && group <= rules.last_group) {
      weight->sum = tree::together(weight->sum, read.inertial.in(spot.X_LF));
      if (read.inertial.mass > 0.0 && read.solid) weight->axes.push_back(spot.X_LF.R * read.solid->X_LS.R);
      if (!read.open.empty()) weight->open.emplace_back(read.open, std::to_string(geom.line));
    }
    if (!read.solid) return;
    if (++n_solids_ > kMostSolids)
      throw std::invalid_argument(fmt::format("{}: there are more than {} geoms", geom.place(), kMostSolids));
    read.solid->X_LS = spot.X_LF * read.solid->X_LS;
    (spot.link < 0 ? scene_.tree.ground : scene_.tree.links[static_cast<std::size_t>(spot.link)].solids)
        .push_back(std::move(*read.solid));
  }

  void read_site(const Node& e, const Spot& spot) {
    if (!e.has("name")) return;
    const Node site = spot.scope.model->defaults.applied(e, spot.child_class, findings_);
    Pose X = pose_of(site, compiler(spot), findings_);
    if (const std::vector<double> ends = xml::numbers(site, "fromto", findings_); ends.size() == 6) {
      const Vector3d a(ends[0], ends[1], ends[2]), b(ends[3], ends[4], ends[5]);
      X.p = 0.5 * (a + b);
      if ((a - b).norm() > 0.0)
        X.R = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), a - b).toRotationMatrix();
    }
    scene_.sites[spot.scope.full(e.get("name"))] = {spot.link, spot.X_LF * X};
  }

  void weigh(const Node& e, const Spot& own, std::size_t link, bool moves, Weight& weight) {
    const Compiler& rules = compiler(own);
    const Node* const given = e.child("inertial");
    tree::Inertial inertial;
    const bool from_geoms = rules.from_geoms == Compiler::FromGeoms::always ||
                            (rules.from_geoms == Compiler::FromGeoms::when_missing && given == nullptr);
    if (!from_geoms && given != nullptr) {
      inertial = read_inertial(*given, rules, findings_).in(own.X_LF);
      if (!given->has("fullinertia"))
        scene_.inertia_axes[static_cast<int>(link)] = own.X_LF.R * pose_of(*given, rules, findings_).R;
    }
    if (from_geoms) {
      if (weight.axes.size() == 1) scene_.inertia_axes[static_cast<int>(link)] = weight.axes.front();
      inertial = weight.sum;
      for (const auto& [why, place] : weight.open) {
        if (moves)
          open_[why].push_back(place);
        else
          ++scene_.passed_over["geoms of bodies that stand, whose mass is not known"];
      }
    }
    if (!from_geoms && !weight.open.empty())
      scene_.passed_over["pictures whose mesh is not there"] += static_cast<int>(weight.open.size());
    bound(inertial, rules);
    scene_.tree.links[link].inertial = inertial;
  }

  void scale_masses(const Compiler& rules) {
    if (!(rules.total_mass > 0.0)) return;
    double total = 0.0;
    for (const tree::Link& link : scene_.tree.links) total += link.inertial.mass;
    if (!(total > 0.0)) return;
    for (tree::Link& link : scene_.tree.links) {
      link.inertial.mass *= rules.total_mass / total;
      link.inertial.inertia *= rules.total_mass / total;
    }
  }

  Findings& findings_;
  Scene scene_;
  Pose global_from_;                                      ///< of the body being read, in the world
  std::map<std::string, std::vector<std::string>> open_;  ///< why a mass is not known, and where
  std::set<std::string> known_scopes_;
  int depth_ = 0;
  std::size_t n_solids_ = 0;
};

}  // namespace

Scene read_scene(const Model& model, Findings& findings) {
  return Bodies(findings).read(model);
}

std::vector<Scope> copies_of(const Node& element, const Model& model, const Scene& scene,
                             const std::vector<Reference>& references, Findings& findings) {
  const auto means_all = [&](const Scope& scope) {
    return std::ranges::all_of(references, [&](const Reference& r) {
      return r.first(scope.full(r.second)) ||
             (&scope != &scene.scopes.front() && scope.model == &model && r.first(r.second));
    });
  };
  std::vector<Scope> copies;
  for (const Scope& scope : scene.scopes) {
    if (scope.model != &model || !means_all(scope)) continue;
    copies.push_back(scope);
    if (&scope == &scene.scopes.front()) return copies;
  }
  if (copies.empty() && scene.scopes.front().model == &model)
    for (const Reference& r : references)
      if (!r.first(r.second))
        xml::fault(findings, element,
                   fmt::format("<{}> names \"{}\", which the file does not have; correct the name",
                               shown(element.tag), shown(r.second)));
  return copies;
}

}  // namespace flexura::import::mjcf
