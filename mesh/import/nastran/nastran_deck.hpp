// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mesh/import/builder.hpp"
#include "mesh/import/imported.hpp"
#include "mesh/import/nastran/nastran_cards.hpp"
#include "mesh/import/nastran/nastran_systems.hpp"

/// One deck, as those who read its cards share it: cards by name, what they became so far, and what was passed over.
namespace flexura::mesh {

/// The directions 1 to 6 that a field of the card names.  Throws std::invalid_argument on other digits.
std::array<bool, 6> components(const std::string& digits, const Card& card);

class NastranDeck {
 public:
  /// Throws std::invalid_argument for elements and properties of one number.
  explicit NastranDeck(const std::filesystem::path& path);

  const std::vector<Card>& cards() const { return cards_; }
  /// Of one name, which is read by that.
  const std::vector<const Card*>& all(const std::string& name);
  /// Of one name, only looked at.
  const std::vector<const Card*>& given(const std::string& name) const;
  void mark_read(const std::string& name) { read_.insert(name); }
  bool is_read(const Card& card) const { return read_.contains(card.name); }

  /// Enters a material; `lamina`: of shells alone.  Throws std::invalid_argument where the number is taken.
  void add_material(std::int64_t id, bool lamina, ImportedMaterial material, const Where& where);
  /// Throws std::invalid_argument where it is not defined.
  Index material(std::int64_t id, const Where& where) const;
  Index shell_material(std::int64_t id, const Where& where) const;
  /// The material with directions along these axes (columns): a copy, or itself where it has none.
  Index material_along(Index material, const Eigen::Matrix3d& axes);
  /// Whether it is one of a fluid (MAT10).
  bool is_fluid(std::int64_t material) const;

  Index node(std::int64_t grid, const Where& where) const { return builder.node(0, grid, where); }
  /// Columns: the displacement axes of a GRID (CD).
  Eigen::Matrix3d axes_at(std::int64_t grid, const Where& where);
  /// The grids of a list that may say "1, THRU, 9".
  std::vector<std::int64_t> grid_list(const Card& card, std::size_t first);
  /// The vector of an orientation: a GRID or three numbers in these axes (columns).
  Eigen::Vector3d orientation(const Card& card, const Eigen::Vector3d& from, const Eigen::Matrix3d& axes);

  ImportedModel model;
  ModelBuilder builder;
  Unused unused, approximated;
  Faults faults;
  NastranSystems systems;

 private:
  void refuse_repeated() const;

  std::set<std::string> names_, read_;
  Implied implied_;
  std::vector<Card> cards_;
  std::map<std::string, std::vector<const Card*>> by_name_;
  std::map<std::int64_t, Index> material_, lamina_;        // lamina: MAT2, MAT8
  std::map<std::pair<Index, std::string>, Index> turned_;  // materials along other axes
};

}  // namespace flexura::mesh
