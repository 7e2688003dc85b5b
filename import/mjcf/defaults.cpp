// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "import/mjcf/model.hpp"

namespace flexura::import::mjcf {
namespace {

constexpr std::array kActuators = {"general", "motor",    "position", "velocity", "intvelocity",
                                   "damper",  "cylinder", "muscle",   "adhesion", "dcmotor"};
constexpr std::array kOrientations = {"quat", "axisangle", "euler", "xyaxes", "zaxis", "fromto"};

bool is_one_of(const auto& list, const std::string& word) {
  return std::ranges::find(list, word) != list.end();
}

// An orientation is said in one way: what the class says in another one does not count beside it.
Node merged(Node under, const Node& over) {
  if (has_orientation(over))
    std::erase_if(under.attributes, [](const auto& a) { return is_one_of(kOrientations, a.first); });
  for (const auto& [key, value] : over.attributes) under.set(key, value);
  under.tag = over.tag;
  under.file = over.file;
  under.line = over.line;
  under.children = over.children;
  return under;
}

}  // namespace

bool has_orientation(const Node& element) {
  return std::ranges::any_of(kOrientations, [&](const char* way) { return element.has(way); });
}

Defaults::Defaults(const Node& root, Findings& findings) {
  classes_["main"];
  for (const Node* section : root.all("default"))
    read(*section, section->get("class", "main"), classes_["main"], findings);
}

void Defaults::read(const Node& element, const std::string& name, const Class& around, Findings& findings) {
  Class own = classes_.contains(name) ? classes_[name] : around;
  for (const Node& setting : element.children) {
    if (setting.tag == "default") continue;
    if (is_one_of(kActuators, setting.tag)) {
      own.actuators.push_back(setting);
      continue;
    }
    Node& kept = own.by_tag[setting.tag];
    kept = merged(kept, setting);
  }
  classes_[name] = own;
  if (!classes_.contains("main")) classes_["main"] = own;
  for (const Node* inner : element.all("default")) {
    if (!inner->has("class")) {
      xml::fault(findings, *inner, "a <default> inside another one has no class; give it one");
      continue;
    }
    read(*inner, inner->get("class"), own, findings);
  }
}

const Defaults::Class* Defaults::of(const Node& element, const std::string& otherwise,
                                    Findings& findings) const {
  const std::string name = element.get("class", otherwise.empty() ? "main" : otherwise);
  const auto found = classes_.find(name);
  if (found != classes_.end()) return &found->second;
  xml::fault(findings, element,
             fmt::format("<{}> is of the class \"{}\", which no <default> has; correct the name",
                         shown(element.tag), shown(name)));
  return nullptr;
}

Node Defaults::applied(const Node& element, const std::string& otherwise, Findings& findings) const {
  const Class* const own = of(element, otherwise, findings);
  if (own == nullptr) return element;
  // Both kinds of tendons have their defaults in <tendon>, all equalities theirs in <equality>.
  const std::string tag = element.tag == "spatial" || element.tag == "fixed" ? "tendon" : element.tag;
  const auto under = own->by_tag.find(tag);
  return under == own->by_tag.end() ? element : merged(under->second, element);
}

std::vector<Node> Defaults::actuators(const Node& element, Findings& findings) const {
  const Class* const own = of(element, "", findings);
  return own == nullptr ? std::vector<Node>{} : own->actuators;
}

}  // namespace flexura::import::mjcf
