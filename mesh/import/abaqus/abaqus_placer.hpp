// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mesh/import/abaqus/abaqus_deck.hpp"
#include "mesh/import/builder.hpp"
#include "mesh/import/imported.hpp"
#include "mesh/import/projection.hpp"

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
  /// An element of an instance (scope).
  using Label = std::pair<int, std::int64_t>;
  std::vector<Index> nodes_of_elements(const std::vector<Label>& labels);
  static std::vector<Label> in_scope(int scope, const std::vector<std::int64_t>& labels);
  void take_assembly_set(const AssemblySet& set);
  /// Shells on the faces of solids without a section of their own mark these faces (as meshers write them): no stiffness.
  void drop_bare_shells();

  void assign(const Section& section, const Part& part, int scope, const Instance* instance);
  void assign(const ElementData& data, const Part& part, int scope, const Instance* instance);
  /// Point masses that stand in one place are one; elements without a section are refused.
  void finish_others();

  /// Nodes that a keyword names by a number, a set, or INSTANCE.number.
  std::vector<Index> named_nodes(const std::string& name, const Where& where);
  std::vector<Index> surface_nodes(const std::string& name, const Where& where);
  /// A surface by its name, "INSTANCE.NAME" where a part defines it; null where there is none.
  struct FoundSurface {
    Surface* surface = nullptr;
    std::string prefix;  ///< of the sets that it names
    int scope = 0;       ///< of the elements that it names by number
  };
  FoundSurface find_surface(const std::string& name);
  /// The faces of a surface of elements; none of a surface of nodes.
  std::vector<SurfaceFace> surface_faces(const std::string& name, const Where& where);
  /// *TIE: nodes of the slave that lie on nodes of the master become one with them, rotations too; others follow the master's
  /// faces.
  void merge_surface_ties();
  /// The displacements of these nodes are those of the master's faces where they stand.
  void tie_between_nodes(const SurfaceTie& tie, const std::vector<Index>& slaves, double tolerance);
  /// Nodes of shells and beams.
  std::set<Index> turning_nodes() const;
  /// u = u_m + theta_m x r, theta = theta_m.
  void follow_with_arm(const SurfaceTie& tie, Index slave, Index master);
  /// Weights of *DISTRIBUTING.
  std::vector<double> nodal_areas(const TieKeyword& tie, const std::vector<Index>& nodes);
  void take_equations();
  /// Axes that a part, or the model level, defines; the global ones for no name.  Throws where there are none such.
  const Orientation& found_orientation(const std::string& name, const std::string& part,
                                       const Where& where) const;
  /// The same where they are those of no place (rectangular).
  Eigen::Matrix3d orientation(const std::string& name, const std::string& part, const Where& where) const;
  /// Columns: the axes of a cell's material.
  Eigen::Matrix3d material_axes(const ModelBuilder::Cell& cell, const Orientation* orientation,
                                const Instance* instance) const;
  Index found_material(const std::string& name, const Where& where) const;
  /// The layers of a section in these axes.
  Index laminate_along(const Section& section, const Eigen::Matrix3d& axes);
  /// The material along these axes: itself, or a copy.
  Index material_along(Index material, const Eigen::Matrix3d& axes);
  void assign_spring(const ElementData& data, ImportedSpring& to, const Eigen::Matrix3d& axes);
  /// Columns: the directions of a node's dofs (*TRANSFORM).
  Eigen::Matrix3d axes_at(Index node) const;
  void resolve_ties();

  Deck deck_;
  ImportedModel model_;
  ModelBuilder builder_;
  std::map<std::pair<int, std::int64_t>, std::size_t> cell_of_, mass_of_, spring_of_;
  std::multimap<std::pair<int, std::int64_t>, std::pair<std::size_t, std::string>>
      bar_of_;                                                   // with the element's type
  std::map<std::pair<std::string, std::string>, Index> turned_;  // materials by name and axes
  std::set<std::pair<int, std::int64_t>> other_labels_;
  std::set<std::size_t> spring_set_, along_;  // springs that have a stiffness; those along their line
  std::map<std::string, std::vector<Index>> set_nodes_;
  std::map<std::string, std::vector<Label>> set_cells_;
  std::map<std::string, int> scope_of_;
  std::map<Index, const Transform*> axes_of_;
};

}  // namespace flexura::mesh::abaqus
