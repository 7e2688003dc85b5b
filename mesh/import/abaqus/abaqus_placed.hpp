// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mesh/import/abaqus/abaqus_deck.hpp"
#include "mesh/import/builder.hpp"
#include "mesh/import/imported.hpp"

/// A deck and what of it stands in the model so far, as those who place its parts, sections and ties share them.
namespace flexura::mesh::abaqus {

struct PlacedDeck {
  /// An element of an instance (scope).
  using Label = std::pair<int, std::int64_t>;

  static std::vector<Label> in_scope(int scope, const std::vector<std::int64_t>& labels);
  std::vector<Index> nodes_of(int scope, const std::vector<std::int64_t>& labels) const;
  std::vector<Index> nodes_of_elements(const std::vector<Label>& labels) const;

  /// Axes that a part, or the model level, defines; the global ones for no name.  Throws where there are none such.
  const Orientation& found_orientation(const std::string& name, const std::string& part,
                                       const Where& where) const;
  /// The same where they are those of no place (rectangular).
  Eigen::Matrix3d orientation(const std::string& name, const std::string& part, const Where& where) const;

  Deck deck;
  ImportedModel model;
  ModelBuilder builder;
  std::map<Label, std::size_t> cell_of, mass_of, spring_of;
  std::multimap<Label, std::pair<std::size_t, std::string>> bar_of;  ///< with the element's type
  std::set<Label> other_labels;
  std::set<std::size_t> along;  ///< springs along their line
  std::map<std::string, std::vector<Index>> set_nodes;
  std::map<std::string, std::vector<Label>> set_cells;
  std::map<std::string, int> scope_of;  ///< instances, in capitals
};

}  // namespace flexura::mesh::abaqus
