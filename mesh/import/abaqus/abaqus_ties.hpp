// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "mesh/import/abaqus/abaqus_placed.hpp"
#include "mesh/import/projection.hpp"

namespace flexura::mesh::abaqus {

/// What binds the nodes of a deck: *TIE, *COUPLING and their kin, *EQUATION; with the surfaces that they name.
class TiePlacer {
 public:
  explicit TiePlacer(PlacedDeck& placed) : placed_(placed) {}

  /// *TIE: nodes of the slave that lie on nodes of the master become one with them, rotations too; others follow the master's
  /// faces.
  void merge_surface_ties();
  void take_equations();
  void resolve_ties();

 private:
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
  /// The displacements of these nodes are those of the master's faces where they stand.
  void tie_between_nodes(const SurfaceTie& tie, const std::vector<Index>& slaves, double tolerance);
  /// Nodes of shells and beams.
  std::set<Index> turning_nodes() const;
  /// u = u_m + theta_m x r, theta = theta_m.
  void follow_with_arm(const SurfaceTie& tie, Index slave, Index master);
  /// Weights of *DISTRIBUTING.
  std::vector<double> nodal_areas(const TieKeyword& tie, const std::vector<Index>& nodes);
  /// Columns: the directions of a node's dofs (*TRANSFORM).
  Eigen::Matrix3d axes_at(Index node) const;

  PlacedDeck& placed_;
  std::map<Index, const Transform*> axes_of_;
};

}  // namespace flexura::mesh::abaqus
