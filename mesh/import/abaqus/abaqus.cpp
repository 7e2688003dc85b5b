// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "mesh/import/abaqus/abaqus_keywords.hpp"
#include "mesh/import/abaqus/abaqus_placed.hpp"
#include "mesh/import/abaqus/abaqus_sections.hpp"
#include "mesh/import/abaqus/abaqus_ties.hpp"
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

/// Nodes, elements and what its sets name.
std::size_t size_of(const Part& part) {
  std::size_t size = part.nodes.size() + part.elements.size() + part.others.size();
  for (const auto* sets : {&part.node_sets, &part.element_sets})
    for (const auto& [name, labels] : *sets) size += labels.size();
  return size;
}

/// Places what a deck says: labels become nodes and cells, names become sets; then sections go to their elements, and ties bind.
class Placer {
 public:
  explicit Placer(Deck&& deck) : sections_(placed_) {
    placed_.deck = std::move(deck);
    placed_.model.materials = std::move(placed_.deck.materials);
  }
  ImportedModel build(const std::filesystem::path& path);

 private:
  /// One part, or the own content of an instance, goes into the model under a scope.
  void place(const Part& part, int scope, const Instance* instance, const std::string& prefix);
  void place_other(const OtherElement& element, int scope);
  void take_assembly_set(const AssemblySet& set);
  /// Shells on the faces of solids without a section of their own mark these faces (as meshers write them): no stiffness.
  void drop_bare_shells();

  PlacedDeck placed_;
  SectionPlacer sections_;
  Implied implied_;
  Faults faults_;
};

ImportedModel Placer::build(const std::filesystem::path& path) {
  place(placed_.deck.parts[0], 0, nullptr, "");
  if (placed_.deck.instances.empty() && placed_.deck.parts.size() > 2)
    placed_.model.messages.push_back("the file has parts but no assembly; each part is taken as it stands");
  const std::size_t placed =
      placed_.deck.instances.empty() ? placed_.deck.parts.size() - 1 : placed_.deck.instances.size();
  int scope = 0;
  std::set<int> known;
  for (const auto& instance : placed_.deck.instances)
    if (!known.insert(instance->part).second)
      implied_.add(size_of(placed_.deck.parts[static_cast<std::size_t>(instance->part)]), instance->where);
  for (const auto& instance : placed_.deck.instances) {
    const std::string prefix = placed > 1 ? instance->name + "." : "";
    Part all = placed_.deck.parts[static_cast<std::size_t>(instance->part)];
    append(all, instance->own);
    placed_.scope_of[upper(instance->name)] = ++scope;
    place(all, scope, instance.get(), prefix);
  }
  if (placed_.deck.instances.empty())
    for (std::size_t p = 1; p < placed_.deck.parts.size(); ++p)
      place(placed_.deck.parts[p], ++scope, nullptr, placed > 1 ? placed_.deck.parts[p].name + "." : "");
  for (const AssemblySet& set : placed_.deck.assembly_sets) take_assembly_set(set);
  faults_.raise();
  TiePlacer ties(placed_);
  ties.merge_surface_ties();
  sections_.finish_others();
  ties.take_equations();
  ties.resolve_ties();
  for (const auto& [name, surface] : placed_.deck.surfaces)
    if (!surface.used) placed_.deck.unused.add("*SURFACE", surface.where);
  drop_bare_shells();
  if (placed_.builder.cells().empty() && placed_.model.bars.empty())
    throw std::invalid_argument(
        path.string() +
        ": holds no solid, shell or beam elements (C3D4, C3D10, C3D8, C3D20, S3, S4, B31, ...)");
  for (const auto& [type, what] : placed_.deck.replaced)
    placed_.model.messages.push_back(fmt::format("{} element{} of type {}: {}", what.first,
                                                 what.first == 1 ? "" : "s", type, what.second));
  for (const std::string& message : placed_.deck.unused.messages("keyword"))
    placed_.model.messages.push_back(message);
  for (const std::string& message : placed_.deck.left_out.messages("element"))
    placed_.model.warnings.push_back(message);
  for (const std::string& message : placed_.deck.otherwise.remarks())
    placed_.model.warnings.push_back(message);
  for (const std::string& message : placed_.deck.unbound.messages("keyword"))
    placed_.model.warnings.push_back(message + ": what it binds stays apart");
  placed_.builder.finish(placed_.model);
  return std::move(placed_.model);
}

void Placer::take_assembly_set(const AssemblySet& set) {
  const auto found = placed_.scope_of.find(set.instance);
  if (!set.instance.empty() && found == placed_.scope_of.end())
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
    nodes = placed_.nodes_of(in, set.labels);
    for (const std::string& name : set.names) {
      const auto other = find(placed_.set_nodes, name);
      if (other == placed_.set_nodes.end()) throw unknown(name);
      implied_.add(other->second.size(), set.where);
      nodes.insert(nodes.end(), other->second.begin(), other->second.end());
    }
    auto& all = placed_.set_nodes[upper(set.name)];
    all.insert(all.end(), nodes.begin(), nodes.end());
  } else {
    std::vector<PlacedDeck::Label> labels = PlacedDeck::in_scope(in, set.labels);
    for (const std::string& name : set.names) {
      const auto other = find(placed_.set_cells, name);
      if (other == placed_.set_cells.end()) throw unknown(name);
      implied_.add(other->second.size(), set.where);
      labels.insert(labels.end(), other->second.begin(), other->second.end());
    }
    nodes = placed_.nodes_of_elements(labels);
    auto& all = placed_.set_cells[upper(set.name)];  // it can go on for another instance
    all.insert(all.end(), labels.begin(), labels.end());
  }
  placed_.builder.add_to_set(set.name, nodes);
}

void Placer::place(const Part& part, int scope, const Instance* instance, const std::string& prefix) {
  for (const NodeLine& node : part.nodes)
    placed_.builder.add_node(scope, node.label,
                             instance ? Eigen::Vector3d(instance->R * node.x + instance->t) : node.x,
                             node.where);
  for (const ElementLine& element : part.elements)
    faults_.guard([&] {
      std::vector<Index> nodes;
      for (const std::int64_t label : element.nodes) {
        if (!placed_.builder.has_node(scope, label))
          throw std::invalid_argument(fmt::format("{}: element {} names node {}, which does not exist",
                                                  element.where.text(), element.label, label));
        nodes.push_back(placed_.builder.node(scope, label, element.where));
      }
      placed_.cell_of[{scope, element.label}] =
          placed_.builder.add_cell(scope, element.type, element.label, std::move(nodes), element.where);
      placed_.builder.cells().back().variant = element.variant;
    });
  for (const OtherElement& element : part.others) faults_.guard([&] { place_other(element, scope); });
  for (const auto& [name, labels] : part.node_sets) {
    placed_.builder.add_to_set(prefix + name, placed_.nodes_of(scope, labels));
    placed_.set_nodes[upper(prefix + name)] = placed_.nodes_of(scope, labels);
    placed_.set_nodes.try_emplace(upper(name), placed_.nodes_of(scope, labels));
    if (instance) placed_.set_nodes[upper(instance->name + "." + name)] = placed_.nodes_of(scope, labels);
  }
  for (const auto& [name, labels] : part.element_sets) {
    placed_.set_cells[upper(prefix + name)] = placed_.set_cells[upper(name)] =
        PlacedDeck::in_scope(scope, labels);
    if (instance) placed_.set_cells[upper(instance->name + "." + name)] = PlacedDeck::in_scope(scope, labels);
  }
  for (const auto& [name, labels] : part.element_sets)
    if (!part.node_sets.contains(name))
      placed_.builder.add_to_set(prefix + name,
                                 placed_.nodes_of_elements(PlacedDeck::in_scope(scope, labels)));
  for (const Section& section : part.sections)
    faults_.guard([&] { sections_.assign(section, part, scope, instance); });
  for (const ElementData& data : part.data)
    faults_.guard([&] { sections_.assign(data, part, scope, instance); });
}

void Placer::place_other(const OtherElement& element, int scope) {
  std::vector<Index> nodes;
  for (const std::int64_t label : element.nodes)
    nodes.push_back(placed_.builder.node(scope, label, element.where));
  const std::pair<int, std::int64_t> key{scope, element.label};
  if (placed_.cell_of.contains(key) || !placed_.other_labels.insert(key).second)
    throw std::invalid_argument(fmt::format("{}: element {} is given twice; element numbers must be unique",
                                            element.where.text(), element.label));
  if (element.type[0] == 'B' || element.type[0] == 'T' || element.type[0] == 'U') {
    const std::size_t own = other_elements().at(element.type);
    for (std::size_t k = 0; k + 1 < own; ++k) {
      ImportedBar bar;
      bar.label = element.label;
      bar.nodes = {nodes[k], nodes[k + 1]};
      if (element.type[0] != 'T' && nodes.size() > own)  // it gives n1 instead of the section
        bar.orientation = placed_.builder.place(nodes[own]) - placed_.builder.place(nodes[0]);
      placed_.bar_of.emplace(key, std::pair{placed_.model.bars.size(), element.type});
      placed_.model.bars.push_back(bar);
    }
  } else if (element.type == "SPRING1" || element.type == "DASHPOT1") {
    placed_.deck.unused.add(element.type + ": to the ground (a superelement is a free body)", element.where);
  } else if (element.type.rfind("SPRING", 0) == 0 || element.type.rfind("DASHPOT", 0) == 0) {
    if (element.type.back() == 'A') placed_.along.insert(placed_.model.springs.size());
    placed_.spring_of[key] = placed_.model.springs.size();
    placed_.model.springs.push_back({.label = element.label, .nodes = {nodes[0], nodes[1]}});
  } else {
    placed_.mass_of[key] = placed_.model.masses.size();
    placed_.model.masses.push_back({.label = element.label, .node = nodes[0]});
  }
}

void Placer::drop_bare_shells() {
  std::vector<ModelBuilder::Cell>& cells = placed_.builder.cells();
  const auto is_bare = [](const ModelBuilder::Cell& cell) {
    return dimension_of(cell.type) == 2 && cell.material < 0;
  };
  const bool has_solids =
      std::ranges::any_of(cells, [](const ModelBuilder::Cell& cell) { return dimension_of(cell.type) == 3; });
  const auto count = std::ranges::count_if(cells, is_bare);
  if (!has_solids || count == 0) return;
  std::erase_if(cells, is_bare);
  placed_.model.messages.push_back(
      fmt::format("{} shell element{} (S3, S4, ...) {} no section and {} not used", count,
                  count == 1 ? "" : "s", count == 1 ? "has" : "have", count == 1 ? "is" : "are"));
}

}  // namespace
}  // namespace flexura::mesh::abaqus

namespace flexura::mesh {

ImportedModel read_abaqus(const std::filesystem::path& path, DeckProgram program) {
  return abaqus::Placer(abaqus::read_deck(path, program)).build(path);
}

}  // namespace flexura::mesh
