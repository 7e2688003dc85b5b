// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/read_mechanism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "mbs/file/complete_model.hpp"
#include "mbs/file/fidelities.hpp"
#include "mbs/file/reader.hpp"

namespace flexura::mbs {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

MechanismFile read_mechanism(const std::filesystem::path& file, const input::TableSchema& solver,
                             const std::vector<std::string>& overrides, PreparationCache* cache) {
  PreparationCache own;  // bodies of one superelement share it
  ReadModel model{.cache = cache ? *cache : own};
  Reader reader(model, file, solver, overrides);
  const input::Section& root = reader.root();
  MechanismDescription& d = model.description;
  d.name = root.title();
  d.gravity = root.vector3("gravity");
  reader.read_bodies();
  reader.read_joints();
  add_free_joints(model);
  for (const JointDescription& joint : d.joints) {
    for (const CoordinateInfo& c : joint.joint->coordinates()) d.signals.add(joint.name + "." + c.name);
    for (const CoordinateInfo& c : joint.joint->speeds()) d.signals.add(joint.name + "." + c.name);
  }
  reader.read_elements();
  prepare_bodies(model);

  MechanismFile out{d.name, text_of(file),          std::move(d),        {}, {},
                    {},     std::move(model.notes), root.table("solver")};
  out.outputs = root.table("output").texts("quantities");
  out.y = root.table("output").texts("y");
  for (const auto& [name, s] : root.table_map("body"))
    if (s.has("superelement") || s.has("beam")) {
      out.deformable.push_back(name);
      if (s.has("fidelity")) out.leaves_fidelity_open[name] = s.text("fidelity") == kAutomaticFidelity;
    }
  out.blind_spots = std::move(model.blind_spots);
  out.states = read_state_sets(root);
  for (const auto& [name, s] : root.table_map("run")) {
    out.runs.push_back({name, s.texts("set")});
    if (s.has("accuracy"))
      out.runs.back().overrides.push_back(fmt::format("solver.accuracy={:.17g}", s.quantity("accuracy")));
    if (s.has("state")) {
      find_state_set(out.states, s.text("state"), s.where("state"));
      out.runs.back().overrides.push_back("solver.initial_state=" + s.text("state"));
    }
  }
  if (out.runs.empty()) out.runs.push_back({"run", {}});
  return out;
}

}  // namespace flexura::mbs
