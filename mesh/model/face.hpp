// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mesh/model/mesh.hpp"

/// What an engineer calls a face of a part: the plane, the bore, the shaft seat.
namespace flexura::mesh {

enum class FaceKind { plane, cylinder, cone, sphere, other };
const char* name_of(FaceKind kind);

/// One face of a CAD part, lengths in m, frame B.  Fields that a kind does not have are zero.
struct Face {
  Index number = 0;  ///< as Mesh::boundary_face names it
  int solid = 0;     ///< number of the solid that owns it (from 1)
  std::string name;  ///< label in the CAD file, may be empty
  FaceKind kind = FaceKind::other;
  double area = 0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< of the area
  Eigen::Matrix<double, 2, 3> box = Eigen::Matrix<double, 2, 3>::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< plane: unit, out of the material
  Eigen::Vector3d axis_point =
      Eigen::Vector3d::Zero();  ///< cylinder, cone: on the axis, mid-extent; sphere: centre
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< cylinder, cone: unit; first non-zero component > 0
  double radius = 0;                               ///< cylinder, sphere; cone: at mid-extent
  double length = 0;                               ///< cylinder, cone: extent along the axis
  double sweep = 0;                                ///< cylinder, cone: angle covered [rad], 2 pi when closed
  bool hole = false;  ///< cylinder, cone, sphere: the material lies outside the surface
};

/// One line: "face 12: bore, radius 12 mm, length 30 mm, axis (0, 0, 1) through (0, 0, 0) mm".
std::string describe(const Face& face);

/// The lines of a part file's [interface.NAME] that choose this face and what lies on the same surface, in m: by cylinder, by plane,
/// otherwise by the place nearest to which it is.
std::string selection_lines(const Face& face);

/// "(1.5, 0, -3)" in mm with four significant digits of the largest component.
std::string describe_point_mm(const Eigen::Vector3d& point);

}  // namespace flexura::mesh
