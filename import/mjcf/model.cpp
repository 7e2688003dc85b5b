// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/mjcf/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "import/xml/values.hpp"

namespace flexura::import::mjcf {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNodes = 1'000'000, kDeepest = 10;

std::size_t count(const Node& node) {
  std::size_t n = 1;
  for (const Node& child : node.children) n += count(child);
  return n;
}

/// Puts what is included in the place of <include>.
class Includes {
 public:
  Includes(const fs::path& main, Findings& findings)
      : folder_(main.parent_path()), findings_(findings), open_{main} {}

  void expand(Node& node) {
    std::vector<Node> children;
    for (Node& child : node.children) {
      if (child.tag != "include") {
        expand(child);
        children.push_back(std::move(child));
        continue;
      }
      for (Node& included : included_by(child)) children.push_back(std::move(included));
    }
    node.children = std::move(children);
  }
  const std::string& missing() const { return missing_; }

 private:
  std::vector<Node> included_by(const Node& include) {
    const std::string name = include.get("file");
    if (name.empty()) {
      xml::fault(findings_, include, "<include> has no file; give it");
      return {};
    }
    const fs::path file = (folder_ / name).lexically_normal();
    std::error_code none;
    if (!fs::is_regular_file(file, none)) {
      missing_ = name;
      xml::repair(
          findings_, include, "includes that are not there",
          fmt::format(
              "the file \"{}\" that it includes is not there ({}); the mechanism is without what it holds: "
              "put it there if that is more than pictures",
              shown(name), file.string()));
      return {};
    }
    if (std::ranges::find(open_, file) != open_.end()) {
      xml::fault(findings_, include,
                 fmt::format("\"{}\" includes itself, directly or by way of others; take the <include> away",
                             shown(name)));
      return {};
    }
    Node root = xml::read(file, "MJCF");
    if ((nodes_ += count(root)) > kMostNodes)
      throw std::invalid_argument(
          fmt::format("{}: more than {} elements are included", include.place(), kMostNodes));
    open_.push_back(file);
    expand(root);
    open_.pop_back();
    return std::move(root.children);
  }

  fs::path folder_;
  Findings& findings_;
  std::vector<fs::path> open_;
  std::string missing_;
  std::size_t nodes_ = 0;
};

void read_compiler(const Node& e, Compiler& c, Findings& findings) {
  const auto wrong = [&](const char* attribute, const char* rule) {
    xml::fault(
        findings, e,
        fmt::format("{} of <compiler> is \"{}\", it must be {}", attribute, shown(e.get(attribute)), rule));
  };
  if (e.has("angle")) {
    c.degree = e.get("angle") == "degree";
    if (!c.degree && e.get("angle") != "radian") wrong("angle", "degree or radian");
  }
  if (e.has("coordinate")) {
    c.global = e.get("coordinate") == "global";
    if (!c.global && e.get("coordinate") != "local") wrong("coordinate", "local or global");
  }
  if (e.has("eulerseq")) {
    const std::string sequence = e.get("eulerseq");
    if (sequence.size() == 3 && sequence.find_first_not_of("xyzXYZ") == std::string::npos)
      c.euler_sequence = sequence;
    else
      wrong("eulerseq", "three letters of xyz, XYZ");
  }
  if (e.get("inertiafromgeom", "auto") != "auto")
    c.from_geoms = xml::flag(e, "inertiafromgeom", false, findings) ? Compiler::FromGeoms::always
                                                                    : Compiler::FromGeoms::never;
  c.autolimits = xml::flag(e, "autolimits", c.autolimits, findings);
  c.balance_inertia = xml::flag(e, "balanceinertia", c.balance_inertia, findings);
  c.strip_path = xml::flag(e, "strippath", c.strip_path, findings);
  c.least_mass = xml::number(e, "boundmass", c.least_mass, findings);
  c.least_inertia = xml::number(e, "boundinertia", c.least_inertia, findings);
  c.total_mass = xml::number(e, "settotalmass", c.total_mass, findings);
  c.mesh_folder = e.get("meshdir", e.get("assetdir", c.mesh_folder));
  if (const std::vector<double> range = xml::numbers(e, "inertiagrouprange", findings); range.size() == 2) {
    c.first_group = static_cast<int>(std::clamp(range[0], -1000.0, 1000.0));
    c.last_group = static_cast<int>(std::clamp(range[1], -1000.0, 1000.0));
  }
}

void read_option(const Node& e, Option& o, Findings& findings) {
  o.gravity = xml::vector(e, "gravity", o.gravity, findings);
  o.wind = xml::vector(e, "wind", o.wind, findings);
  o.density = xml::number(e, "density", o.density, findings);
  o.viscosity = xml::number(e, "viscosity", o.viscosity, findings);
  for (const Node* flags : e.all("flag")) {
    const auto is_off = [&](const char* name) { return flags->get(name) == "disable"; };
    if (is_off("gravity")) o.gravity.setZero();
    if (is_off("passive") || is_off("spring")) o.springs = false;
    if (is_off("passive") || is_off("damper")) o.dampers = false;
    if (is_off("limit") || is_off("constraint")) o.limits = false;
    if (is_off("frictionloss") || is_off("constraint")) o.friction = false;
    if (is_off("equality") || is_off("constraint")) o.equality = false;
    if (is_off("actuation")) o.actuation = false;
    if (is_off("clampctrl")) o.clamp_controls = false;
  }
}

std::shared_ptr<Model> read_with_attached(const fs::path& file, Findings& findings,
                                          std::vector<fs::path>& open) {
  auto model = std::make_shared<Model>();
  model->file = file;
  model->root = xml::read(file, "MJCF");
  const bool is_mjcf = model->root.tag == "mujoco";
  if (!is_mjcf)
    throw std::invalid_argument(
        fmt::format("{}: is no MJCF: its outermost element is <{}>, <mujoco> is wanted{}",
                    model->root.place(), shown(model->root.tag),
                    model->root.tag == "mujocoinclude" ? "; import the file that includes this one" : ""));
  Includes includes(file, findings);
  includes.expand(model->root);
  model->missing_include = includes.missing();
  for (const Node* e : model->sections("compiler")) read_compiler(*e, model->compiler, findings);
  for (const Node* e : model->sections("option")) read_option(*e, model->option, findings);
  model->defaults = Defaults(model->root, findings);
  for (const Node* section : model->sections("asset")) {
    for (const Node* e : section->all("mesh")) {
      Node mesh = model->defaults.applied(*e, "", findings);
      model->meshes[mesh.get("name", fs::path(mesh.get("file")).stem().string())] = mesh;
    }
    for (const Node* e : section->all("model")) {
      const fs::path child = (file.parent_path() / e->get("file")).lexically_normal();
      std::error_code none;
      if (!fs::is_regular_file(child, none)) {
        xml::fault(findings, *e,
                   fmt::format("the model \"{}\" that is attached is not there ({}); put it there",
                               shown(e->get("file")), child.string()));
      } else if (std::ranges::find(open, child) != open.end() || open.size() > kDeepest) {
        xml::fault(findings, *e,
                   fmt::format("the model \"{}\" attaches itself, or as the tenth in a row; take it away",
                               shown(e->get("file"))));
      } else {
        open.push_back(child);
        auto attached = read_with_attached(child, findings, open);
        open.pop_back();
        model->models[e->get("name", attached->root.get("model"))] = attached;
      }
    }
  }
  return model;
}

}  // namespace

std::shared_ptr<Model> read_model(const fs::path& file, Findings& findings) {
  std::vector<fs::path> open = {file.lexically_normal()};
  return read_with_attached(file.lexically_normal(), findings, open);
}

}  // namespace flexura::import::mjcf
