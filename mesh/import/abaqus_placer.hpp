// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mesh/import/abaqus_deck.hpp"
#include "mesh/import/builder.hpp"
#include "mesh/import/imported.hpp"

namespace flexura::mesh::abaqus {

/// Places what a deck says: labels become nodes and cells, names become sets, sections go to their elements.  Nodes, elements
/// and sets are placed in abaqus.cpp; sections, stiffness and mass in abaqus_sections.cpp; surfaces and ties in
/// abaqus_ties.cpp.
class Placer {
 public:
  explicit Placer(Deck&& deck) : deck_(std::move(deck)) { model_.materials = std::move(deck_.materials); }
  ImportedModel build(const std::filesystem::path& path);

 private:
  /// One part, or the own content of an instance, goes into the model under a scope.
  void place(const Part& part, int scope, const Instance* instance, const std::string& prefix);
  void place_other(const OtherElement& element, int scope);
  std::vector<Index> nodes_of(int scope, const std::vector<std::int64_t>& labels) const;
  std::vector<Index> nodes_of_elements(int scope, const std::vector<std::int64_t>& labels);
  /// Shells on the faces of solids without a section of their own mark these faces (as meshers write them): no stiffness.
  void drop_bare_shells();

  void assign(const Section& section, const Part& part, int scope, const Instance* instance);
  void assign(const ElementData& data, const Part& part, int scope, const Instance* instance);
  /// Point masses that stand in one place are one; elements without a section are refused.
  void finish_others();

  /// Nodes that a keyword names by a number, a set, or INSTANCE.number.
  std::vector<Index> named_nodes(const std::string& name, const Where& where);
  std::vector<Index> surface_nodes(const std::string& name, const Where& where);
  /// *TIE: nodes of the slave that lie on nodes of the master become one with them, rotations too.  Between nodes the
  /// surfaces stay apart, which is a warning.
  void merge_surface_ties();
  void resolve_ties();

  Deck deck_;
  ImportedModel model_;
  ModelBuilder builder_;
  std::map<std::pair<int, std::int64_t>, std::size_t> cell_of_, mass_of_, spring_of_;
  std::map<std::pair<int, std::int64_t>, std::pair<std::size_t, std::string>>
      bar_of_;  // with the element's type
  std::set<std::pair<int, std::int64_t>> other_labels_;
  std::set<std::size_t> spring_set_;
  std::map<std::string, std::vector<Index>> set_nodes_;
  std::map<std::string, std::pair<int, std::vector<std::int64_t>>> set_cells_;
  std::map<std::string, int> scope_of_;
};

}  // namespace flexura::mesh::abaqus
