// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "mesh/model/face.hpp"
#include "mesh/model/mesh.hpp"

/// Interfaces chosen by what an engineer knows about them.
///
/// With CAD faces at hand (mesh.boundary_face and a list of Face) whole faces are chosen by their exact
/// geometry; on foreign meshes the rules judge the boundary cells: every node on the surface and the cell's
/// normal along the surface's.  Where shells have no such face, their free edges are taken that lie in the plane or, with the
/// radius given, about the axis.  All lengths in m, frame B.
namespace flexura::mesh {

/// All cylindrical faces about an axis: one bore, or several bores in line.
struct CylinderRule {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< anywhere on the axis
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  std::optional<double> radius;  ///< empty: the only radius found about this axis
  std::optional<std::array<double, 2>>
      extent;            ///< least and greatest distance along `direction` from `point`
  double tolerance = 0;  ///< on axis distance and radius; 0 = 0.5 % of the radius
};
struct PlaneRule {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< either sign
  double tolerance = 0;                               ///< 0 = 1e-4 of the part's diagonal
};
/// All faces that come within `radius` of a point; without a radius the nearest face.
struct NearRule {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  std::optional<double> radius;
};
struct FacesRule {
  std::vector<Index> numbers;  ///< as --list-faces shows them
};
/// A named set of the mesh or the name of CAD faces.
struct NameRule {
  std::string name;
};
/// Nodes by number in the file that they come from (without labels: counted from 1), by place, or both.
struct NodesRule {
  std::vector<std::int64_t> labels;
  std::vector<Eigen::Vector3d> points;  ///< the node nearest to each, which must lie within `tolerance`
  double tolerance = 0;                 ///< 0 = 1e-6 of the part's diagonal
};
using Rule = std::variant<CylinderRule, PlaneRule, NearRule, FacesRule, NameRule, NodesRule>;

struct Selection {
  NodeSet set;  ///< nodes ascending; faces where the rule chose faces (area weights)
  Eigen::Vector3d reference =
      Eigen::Vector3d::Zero();      ///< default interface node: on the axis of a cylinder at
                                    ///< the area centroid's height; else the area centroid
  double area = 0;                  ///< [m^2] of the chosen faces as meshed
  std::vector<Index> face_numbers;  ///< CAD faces chosen, ascending; empty on foreign meshes
  std::string description;          ///< one line on what was chosen
};

/// Throws std::invalid_argument when nothing fits; the text names the nearest candidates
/// ("no cylinder of radius 12 mm about ...; nearest cylinder: radius 12.5 mm at ...").
/// `faces` may be empty.
Selection select_nodes(const Mesh& mesh, const std::vector<Face>& faces, const Rule& rule);

}  // namespace flexura::mesh
