// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "mesh/import/abaqus/abaqus_placed.hpp"

namespace flexura::mesh::abaqus {

/// Gives elements that are placed their sections, materials along axes, stiffness and mass.
class SectionPlacer {
 public:
  explicit SectionPlacer(PlacedDeck& placed) : placed_(placed) {}

  /// To the elements of the set that they name, which are placed under that scope.
  void assign(const Section& section, const Part& part, int scope, const Instance* instance);
  void assign(const ElementData& data, const Part& part, int scope, const Instance* instance);
  /// Point masses that stand in one place are one; elements without a section are refused.
  void finish_others();

 private:
  /// Columns: the axes of a cell's material.
  Eigen::Matrix3d material_axes(const ModelBuilder::Cell& cell, const Orientation* orientation,
                                const Instance* instance) const;
  Index found_material(const std::string& name, const Where& where) const;
  /// The layers of a section in these axes.
  using LayerAxes = std::function<Eigen::Matrix3d(const std::string& orientation)>;
  Index laminate_along(const Section& section, const Eigen::Matrix3d& axes, const LayerAxes& of_layer);
  /// The material along these axes: itself, or a copy.
  Index material_along(Index material, const Eigen::Matrix3d& axes);
  void assign_spring(const ElementData& data, ImportedSpring& to, const Eigen::Matrix3d& axes);

  PlacedDeck& placed_;
  std::map<std::pair<std::string, std::string>, Index> turned_;  // materials by name and axes
  std::map<std::pair<int, std::int64_t>, Where> section_of_;     // elements by scope and label
  std::set<std::size_t> spring_set_;                             // springs that have a stiffness
};

}  // namespace flexura::mesh::abaqus
