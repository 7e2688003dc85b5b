// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "mesh/import/abaqus/abaqus_keywords.hpp"
#include "mesh/import/abaqus/abaqus_placer.hpp"
#include "mesh/import/abaqus/abaqus_types.hpp"
#include "mesh/model/cells/cell.hpp"

namespace flexura::mesh::abaqus {
namespace {

void append(Part& to, const Part& from) {
  to.nodes.insert(to.nodes.end(), from.nodes.begin(), from.nodes.end());
  to.elements.insert(to.elements.end(), from.elements.begin(), from.elements.end());
  for (const auto& [name, labels] : from.node_sets) {
    auto& own = to.node_sets[name];
    own.insert(own.end(), labels.begin(), labels.end());
  }
  for (const auto& [name, labels] : from.element_sets) {
    auto& own = to.element_sets[name];
    own.insert(own.end(), labels.begin(), labels.end());
  }
  to.sections.insert(to.sections.end(), from.sections.begin(), from.sections.end());
  to.others.insert(to.others.end(), from.others.begin(), from.others.end());
  to.data.insert(to.data.end(), from.data.begin(), from.data.end());
}

}  // namespace

ImportedModel Placer::build(const std::filesystem::path& path) {
  place(deck_.parts[0], 0, nullptr, "");
  if (deck_.instances.empty() && deck_.parts.size() > 2)
    model_.messages.push_back("the file has parts but no assembly; each part is taken as it stands");
  const std::size_t placed = deck_.instances.empty() ? deck_.parts.size() - 1 : deck_.instances.size();
  std::map<std::string, int>& scope_of = scope_of_;
  int scope = 0;
  for (const auto& instance : deck_.instances) {
    const std::string prefix = placed > 1 ? instance->name + "." : "";
    Part all = deck_.parts[static_cast<std::size_t>(instance->part)];
    append(all, instance->own);
    scope_of[upper(instance->name)] = ++scope;
    place(all, scope, instance.get(), prefix);
  }
  if (deck_.instances.empty())
    for (std::size_t p = 1; p < deck_.parts.size(); ++p)
      place(deck_.parts[p], ++scope, nullptr, placed > 1 ? deck_.parts[p].name + "." : "");
  for (const AssemblySet& set : deck_.assembly_sets) take_assembly_set(set);
  merge_surface_ties();
  finish_others();
  take_equations();
  resolve_ties();
  for (const auto& [name, surface] : deck_.surfaces)
    if (!surface.used) deck_.unused.add("*SURFACE", surface.where);
  drop_bare_shells();
  if (builder_.cells().empty() && model_.bars.empty())
    throw std::invalid_argument(
        path.string() +
        ": holds no solid, shell or beam elements (C3D4, C3D10, C3D8, C3D20, S3, S4, B31, ...)");
  for (const auto& [type, what] : deck_.replaced)
    model_.messages.push_back(fmt::format("{} element{} of type {}: {}", what.first,
                                          what.first == 1 ? "" : "s", type, what.second));
  for (const std::string& message : deck_.unused.messages("keyword")) model_.messages.push_back(message);
  for (const std::string& message : deck_.left_out.messages("element")) model_.warnings.push_back(message);
  for (const std::string& message : deck_.otherwise.remarks()) model_.warnings.push_back(message);
  for (const std::string& message : deck_.unbound.messages("keyword"))
    model_.warnings.push_back(message + ": what it binds stays apart");
  builder_.finish(model_);
  return std::move(model_);
}

void Placer::take_assembly_set(const AssemblySet& set) {
  const auto found = scope_of_.find(set.instance);
  if (!set.instance.empty() && found == scope_of_.end())
    throw std::invalid_argument(fmt::format("{}: set \"{}\" is of an instance \"{}\" that is not defined",
                                            set.where.text(), set.name, set.instance));
  const int in = set.instance.empty() ? 0 : found->second;
  // Sets that it names are of the assembly, of an instance ("I.S"), or of the one that the set is of.
  const auto find = [&](const auto& sets, const std::string& name) {
    const auto own = sets.find(set.instance.empty() ? upper(name) : set.instance + "." + upper(name));
    return own != sets.end() ? own : sets.find(upper(name));
  };
  const auto unknown = [&](const std::string& name) {
    return std::invalid_argument(fmt::format("{}: set \"{}\" names a set \"{}\" that is not defined",
                                             set.where.text(), set.name, name));
  };
  std::vector<Index> nodes;
  if (set.of_nodes) {
    nodes = nodes_of(in, set.labels);
    for (const std::string& name : set.names) {
      const auto other = find(set_nodes_, name);
      if (other == set_nodes_.end()) throw unknown(name);
      nodes.insert(nodes.end(), other->second.begin(), other->second.end());
    }
    auto& all = set_nodes_[upper(set.name)];
    all.insert(all.end(), nodes.begin(), nodes.end());
  } else {
    std::vector<Label> labels = in_scope(in, set.labels);
    for (const std::string& name : set.names) {
      const auto other = find(set_cells_, name);
      if (other == set_cells_.end()) throw unknown(name);
      labels.insert(labels.end(), other->second.begin(), other->second.end());
    }
    nodes = nodes_of_elements(labels);
    auto& all = set_cells_[upper(set.name)];  // it can go on for another instance
    all.insert(all.end(), labels.begin(), labels.end());
  }
  builder_.add_to_set(set.name, nodes);
}

std::vector<Placer::Label> Placer::in_scope(int scope, const std::vector<std::int64_t>& labels) {
  std::vector<Label> out;
  for (const std::int64_t label : labels) out.emplace_back(scope, label);
  return out;
}

void Placer::place(const Part& part, int scope, const Instance* instance, const std::string& prefix) {
  for (const NodeLine& node : part.nodes)
    builder_.add_node(scope, node.label,
                      instance ? Eigen::Vector3d(instance->R * node.x + instance->t) : node.x, node.where);
  for (const ElementLine& element : part.elements) {
    std::vector<Index> nodes;
    for (const std::int64_t label : element.nodes) {
      if (!builder_.has_node(scope, label))
        throw std::invalid_argument(fmt::format("{}: element {} names node {}, which does not exist",
                                                element.where.text(), element.label, label));
      nodes.push_back(builder_.node(scope, label, element.where));
    }
    cell_of_[{scope, element.label}] =
        builder_.add_cell(scope, element.type, element.label, std::move(nodes), element.where);
    builder_.cells().back().variant = element.variant;
  }
  for (const OtherElement& element : part.others) place_other(element, scope);
  for (const auto& [name, labels] : part.node_sets) {
    builder_.add_to_set(prefix + name, nodes_of(scope, labels));
    set_nodes_[upper(prefix + name)] = nodes_of(scope, labels);
    set_nodes_.try_emplace(upper(name), nodes_of(scope, labels));
    if (instance) set_nodes_[upper(instance->name + "." + name)] = nodes_of(scope, labels);
  }
  for (const auto& [name, labels] : part.element_sets) {
    set_cells_[upper(prefix + name)] = set_cells_[upper(name)] = in_scope(scope, labels);
    if (instance) set_cells_[upper(instance->name + "." + name)] = in_scope(scope, labels);
  }
  for (const auto& [name, labels] : part.element_sets)
    if (!part.node_sets.contains(name))
      builder_.add_to_set(prefix + name, nodes_of_elements(in_scope(scope, labels)));
  for (const Section& section : part.sections) assign(section, part, scope, instance);
  for (const ElementData& data : part.data) assign(data, part, scope, instance);
}

void Placer::place_other(const OtherElement& element, int scope) {
  std::vector<Index> nodes;
  for (const std::int64_t label : element.nodes) nodes.push_back(builder_.node(scope, label, element.where));
  const std::pair<int, std::int64_t> key{scope, element.label};
  if (cell_of_.contains(key) || !other_labels_.insert(key).second)
    throw std::invalid_argument(fmt::format("{}: element {} is given twice; element numbers must be unique",
                                            element.where.text(), element.label));
  if (element.type[0] == 'B' || element.type[0] == 'T') {
    const std::size_t own = other_elements().at(element.type);
    for (std::size_t k = 0; k + 1 < own; ++k) {
      ImportedBar bar;
      bar.label = element.label;
      bar.nodes = {nodes[k], nodes[k + 1]};
      if (element.type[0] == 'B' && nodes.size() > own)  // it gives n1 instead of the section
        bar.orientation = builder_.place(nodes[own]) - builder_.place(nodes[0]);
      bar_of_.emplace(key, std::pair{model_.bars.size(), element.type});
      model_.bars.push_back(bar);
    }
  } else if (element.type == "SPRING1") {
    deck_.unused.add("SPRING1: to the ground (a superelement is a free body)", element.where);
  } else if (element.type.rfind("SPRING", 0) == 0) {
    if (element.type == "SPRINGA") along_.insert(model_.springs.size());
    spring_of_[key] = model_.springs.size();
    model_.springs.push_back({.label = element.label, .nodes = {nodes[0], nodes[1]}});
  } else {
    mass_of_[key] = model_.masses.size();
    model_.masses.push_back({.label = element.label, .node = nodes[0]});
  }
}

std::vector<Index> Placer::nodes_of(int scope, const std::vector<std::int64_t>& labels) const {
  std::vector<Index> nodes;  // GENERATE may name labels that do not exist: Abaqus leaves them out, too
  for (const std::int64_t label : labels)
    if (builder_.has_node(scope, label)) nodes.push_back(builder_.node(scope, label, {}));
  return nodes;
}

std::vector<Index> Placer::nodes_of_elements(const std::vector<Label>& labels) {
  std::vector<Index> nodes;
  for (const Label& label : labels)
    if (const auto found = cell_of_.find(label); found != cell_of_.end()) {
      const auto& cell = builder_.cells()[found->second].nodes;
      nodes.insert(nodes.end(), cell.begin(), cell.end());
    } else {
      for (auto [bar, end] = bar_of_.equal_range(label); bar != end; ++bar) {
        const auto& ends = model_.bars[bar->second.first].nodes;
        nodes.insert(nodes.end(), ends.begin(), ends.end());
      }
    }
  std::erase(nodes, -1);
  return nodes;
}

void Placer::drop_bare_shells() {
  std::vector<ModelBuilder::Cell>& cells = builder_.cells();
  const auto is_bare = [](const ModelBuilder::Cell& cell) {
    return dimension_of(cell.type) == 2 && cell.material < 0;
  };
  const bool has_solids =
      std::ranges::any_of(cells, [](const ModelBuilder::Cell& cell) { return dimension_of(cell.type) == 3; });
  const auto count = std::ranges::count_if(cells, is_bare);
  if (!has_solids || count == 0) return;
  std::erase_if(cells, is_bare);
  model_.messages.push_back(fmt::format("{} shell element{} (S3, S4, ...) {} no section and {} not used",
                                        count, count == 1 ? "" : "s", count == 1 ? "has" : "have",
                                        count == 1 ? "is" : "are"));
}

}  // namespace flexura::mesh::abaqus

namespace flexura::mesh {

ImportedModel read_abaqus(const std::filesystem::path& path) {
  return abaqus::Placer(abaqus::read_deck(path)).build(path);
}

}  // namespace flexura::mesh
