// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/sdf/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "import/sdf/files.hpp"
#include "import/xml/values.hpp"

namespace flexura::import::sdf {
namespace {

namespace fs = std::filesystem;
using xml::Node;

constexpr std::size_t kMostLinks = 20'000, kDeepest = 30;

bool says(const Node& element, const char* tag) {
  const Node* const child = element.child(tag);
  return child != nullptr && (child->text == "true" || child->text == "1");
}

class Reader {
 public:
  Reader(const std::vector<std::string>& packages, Findings& findings)
      : packages_(packages), findings_(findings) {}

  World read(const fs::path& file) {
    world_.file = file;
    const Node& root = open(file);
    if (root.tag != "sdf" && root.tag != "gazebo")
      throw std::invalid_argument(fmt::format("{}: is no SDF: its outermost element is <{}>, <sdf> is wanted",
                                              root.place(), shown(root.tag)));
    version_ = xml::parse_number(root.get("version", "1.4")).value_or(1.4);
    open_.push_back(fs::absolute(file).lexically_normal());
    for (const Node& e : root.children) {
      if (e.tag == "world") {
        if (const Node* gravity = e.child("gravity")) {
          const auto g = xml::parse_numbers(gravity->text);
          if (g && g->size() == 3)
            world_.gravity = {(*g)[0], (*g)[1], (*g)[2]};
          else
            xml::fault(findings_, *gravity,
                       fmt::format("<gravity> is \"{}\", three finite numbers are wanted; correct it",
                                   shown(gravity->text)));
        } else {
          world_.gravity.z() = -9.8;  // the format's own
        }
        world_.name = e.get("name");
        read_children(e, "", false);
      }
    }
    read_children(root, "", false);
    note_others();
    return std::move(world_);
  }

 private:
  const Node& open(const fs::path& file) {
    if (world_.documents.size() > 10'000)
      throw std::invalid_argument(file.string() + ": more than 10000 files are included");
    world_.documents.push_back(std::make_unique<Node>(xml::read(file, "SDF", findings_)));
    return *world_.documents.back();
  }

  void read_children(const Node& parent, const std::string& scope, bool is_static) {
    for (const Node& e : parent.children) {
      if (e.tag == "model") read_model(e, e, scope, is_static);
      if (e.tag == "include") include(e, scope, is_static);
      if (e.tag == "frame") add_frame(e, scope);
      if (scope.empty()) {
        if (e.tag == "actor" || e.tag == "light" || e.tag == "plugin") ++others_[e.tag];
        if (e.tag == "joint") world_.joints.push_back({&e, e.get("name"), scope, version_, false});
        continue;
      }
      if (e.tag == "link") read_link(e, scope, is_static);
      if (e.tag == "joint") read_joint(e, scope);
      if (e.tag == "plugin") note_plugin(e);
      if (e.tag == "gripper" || e.tag == "projector" || e.tag == "allow_auto_disable") ++others_[e.tag];
    }
  }

  static std::string parent_frame(const std::string& scope) {
    return scope.empty() ? "world" : scope + "__model__";
  }

  // Frames are given in others of the same model.
  std::string relative_to(const Node& e, const std::string& scope, const std::string& otherwise) const {
    const Node* const pose = e.child("pose");
    const std::string name =
        pose == nullptr ? "" : pose->get("relative_to", version_ < 1.7 ? pose->get("frame") : "");
    if (name.empty()) return otherwise;
    return name == "world" || name == "__root__" ? "world" : scope + name;
  }

  // `pose` stands where `model` does, or where it is included.
  void read_model(const Node& model, const Node& place, const std::string& scope, bool is_static) {
    const std::string name = scope + place.get("name", model.get("name"));
    if (world_.name.empty()) world_.name = name;
    const std::string inner = name + "::";
    if (++depth_ > kDeepest)
      throw std::invalid_argument(
          fmt::format("{}: models are nested more than {} deep", model.place(), kDeepest));
    if (world_.frames.has(inner + "__model__")) {
      xml::fault(findings_, place, fmt::format("a second model \"{}\"; names must differ", shown(name)));
      --depth_;
      return;
    }
    const Node& posed = place.child("pose") != nullptr ? place : model;
    Frames::Frame frame{relative_to(posed, scope, parent_frame(scope)), pose_in(posed, findings_)};
    if (const Node* placed = place.child("placement_frame"))
      frame.placed = inner + placed->text;
    else if (model.has("placement_frame"))
      frame.placed = inner + model.get("placement_frame");
    world_.frames.add(inner + "__model__", frame);
    world_.frames.add(name, {inner + "__model__", {}});
    const std::size_t first = world_.links.size();
    read_children(model, inner, is_static || says(model, "static") || says(place, "static"));
    const std::string wanted = model.get("canonical_link");
    if (!wanted.empty())
      world_.canonical[inner] = inner + wanted;
    else if (world_.links.size() > first)
      world_.canonical[inner] = world_.links[first].name;
    --depth_;
  }

  void include(const Node& e, const std::string& scope, bool is_static) {
    const Node* const uri = e.child("uri");
    if (uri == nullptr || uri->text.empty()) {
      xml::fault(findings_, e, "<include> has no <uri>; give it");
      return;
    }
    const fs::path found = find_uri(uri->text, e.file ? *e.file : world_.file, packages_);
    const fs::path file = found.empty() ? fs::path() : model_file(found);
    if (file.empty()) {
      // What lies about everywhere: light, and a ground that is felt by contact alone.
      if (uri->text == "model://sun" || uri->text == "model://ground_plane")
        ++others_[uri->text.substr(8)];
      else
        xml::fault(
            findings_, e,
            fmt::format("\"{}\", which is included, is not there; put its folder beside the file, or name "
                        "it with --package NAME=FOLDER",
                        shown(uri->text)));
      return;
    }
    const fs::path absolute = fs::absolute(file).lexically_normal();
    if (std::ranges::find(open_, absolute) != open_.end()) {
      xml::fault(findings_, e,
                 fmt::format("\"{}\" includes itself, directly or by way of others; take the <include> away",
                             shown(uri->text)));
      return;
    }
    const Node& root = open(file);
    const Node* const model = root.child("model");
    if (model == nullptr) {
      if (root.child("light") == nullptr && root.child("actor") == nullptr)
        xml::fault(findings_, e, fmt::format("\"{}\" holds no <model>", shown(uri->text)));
      return;
    }
    open_.push_back(absolute);
    const double outer = std::exchange(version_, xml::parse_number(root.get("version", "1.4")).value_or(1.4));
    Node place = e;
    if (const Node* name = e.child("name")) place.set("name", name->text);
    world_.documents.push_back(std::make_unique<Node>(std::move(place)));
    read_model(*model, *world_.documents.back(), scope, is_static);
    version_ = outer;
    open_.pop_back();
  }

  void add_frame(const Node& e, const std::string& scope) {
    const std::string attached = e.get("attached_to");
    const std::string base = attached.empty()      ? parent_frame(scope)
                             : attached == "world" ? "world"
                                                   : scope + attached;
    world_.frames.add(scope + e.get("name"), {relative_to(e, scope, base), pose_in(e, findings_), "", base});
  }

  void read_link(const Node& e, const std::string& scope, bool is_static) {
    const std::string name = scope + e.get("name");
    if (world_.links.size() >= kMostLinks)
      throw std::invalid_argument(fmt::format("{}: there are more than {} links", e.place(), kMostLinks));
    if (world_.frames.has(name)) {
      xml::fault(findings_, e,
                 fmt::format("a second \"{}\"; names of links, joints and frames must differ", shown(name)));
      return;
    }
    world_.frames.add(name, {relative_to(e, scope, scope + "__model__"), pose_in(e, findings_), "", name});
    world_.links.push_back({&e, name, scope, version_, is_static || says(e, "kinematic")});
    if (says(e, "kinematic"))
      note_once(e, "links that stand", fmt::format("link \"{}\" is kinematic: it stands here", shown(name)));
    if (!e.all("sensor").empty()) others_["sensor"] += static_cast<int>(e.all("sensor").size());
    if (!e.all("collision").empty()) others_["collision"] += static_cast<int>(e.all("collision").size());
    for (const Node* plugin : e.all("plugin")) note_plugin(*plugin);
    if (const Node* decay = e.child("velocity_decay"))
      for (const Node& part : decay->children)
        if (xml::parse_number(part.text).value_or(0.0) != 0.0)
          note_once(
              e, "dampings left out",
              fmt::format("link \"{}\": velocity_decay is left out: it is a number of a solver, no damping",
                          shown(name)));
  }

  void read_joint(const Node& e, const std::string& scope) {
    const std::string name = scope + e.get("name");
    const Node* const child = e.child("child");
    const std::string base = child == nullptr || child->text.empty() ? scope + "__model__"
                             : child->text == "world"                ? "world"
                                                                     : scope + child->text;
    if (!world_.frames.has(name))  // a link may have the name in older files
      world_.frames.add(name, {relative_to(e, scope, base), pose_in(e, findings_), "", base});
    world_.frames.add("joint " + name, {relative_to(e, scope, base), pose_in(e, findings_), "", base});
    world_.joints.push_back({&e, name, scope, version_, false});
  }

  void note_once(const Node& e, const char* kind, const std::string& text) {
    xml::note(findings_, e, kind, text);
  }

  void note_plugin(const Node& e) {
    xml::note(findings_, e, "plugins left out",
              fmt::format("plugin \"{}\" ({}) is left out: what it does to the model is a program's",
                          shown(e.get("name")), shown(e.get("filename"))));
  }

  void note_others() {
    std::string list;
    for (const auto& [what, n] : others_)
      list +=
          fmt::format("{}{} {}", list.empty() ? "" : ", ", n,
                      what == "collision" ? "collision (contact is a force of the mechanism file)" : what);
    if (!list.empty()) findings_.note("lists of what is passed over", "passed over: " + list);
  }

  const std::vector<std::string>& packages_;
  Findings& findings_;
  World world_;
  double version_ = 1.4;
  std::vector<fs::path> open_;
  std::map<std::string, int> others_;
  std::size_t depth_ = 0;
};

}  // namespace

std::string World::resolve(const std::string& wanted, const std::string& scope) const {
  if (wanted == "world") return "world";
  for (std::string at = scope;;) {  // in the model, else in those around it
    if (frames.has(at + wanted)) return at + wanted;
    if (at.empty()) break;
    const auto end = at.rfind("::", at.size() - 3);
    at = end == std::string::npos || at.size() < 3 ? "" : at.substr(0, end + 2);
  }
  // Models that are merged have their links under their own names here.
  std::string found;
  for (const Source& link : links)
    if (link.name.ends_with("::" + wanted)) {
      if (!found.empty()) return {};
      found = link.name;
    }
  return found;
}

std::string World::link_of(const std::string& wanted, const std::string& scope) const {
  std::string at = resolve(wanted, scope);
  for (int step = 0; step < 1000 && !at.empty() && at != "world"; ++step) {
    if (std::ranges::find(links, at, &Source::name) != links.end()) return at;
    if (at.ends_with("::__model__")) at.resize(at.size() - 11);
    if (const auto model = canonical.find(at + "::"); model != canonical.end()) {
      at = model->second;
      continue;
    }
    const Frames::Frame* const frame = frames.find(at);
    at = frame == nullptr ? "" : frame->link;
  }
  return at;
}

World read_world(const fs::path& file, const std::vector<std::string>& packages, Findings& findings) {
  return Reader(packages, findings).read(file);
}

}  // namespace flexura::import::sdf
