// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "import/cad/assembly.hpp"
#include "import/cad/freedom.hpp"

/// Where two placed parts touch, by what their faces are: a shaft in a bore, plane on plane, ball in socket. Touching means a
/// gap (or an overlap) of at most `clearance`, axes that coincide within it, planes that look at each other.
namespace flexura::import::cad {

/// The faces of an instance in the world.
struct PlacedFace {
  mesh::FaceKind kind = mesh::FaceKind::other;
  int number = 0;  ///< from 1, in the part
  bool hole = false;
  double radius = 0.0;
  Vector3d normal, point, axis;  ///< as of mesh::Face; of a plane, `point` lies in it
  Vector3d low, high;            ///< box
  const Face* face = nullptr;
};

struct PlacedPart {
  std::vector<PlacedFace> faces;
  std::vector<Vector3d> vertices;  ///< of the part's surface, in the world
  Vector3d low, high;
};

PlacedPart place(const Part& part, const Pose& X_WP);

struct FacePair {
  int face_a = 0, face_b = 0;  ///< numbers
  mesh::FaceKind kind = mesh::FaceKind::other;
  bool shaft_in_a = false;  ///< cylinder, sphere: A has the convex face
  double radius = 0.0;      ///< of the convex face
  double gap = 0.0;         ///< [m], negative: overlap
  double extent = 0.0;      ///< cylinder: length of the overlap [m]; plane, sphere: its area [m^2]
  Vector3d point, axis;     ///< middle of the contact; axis of the cylinder, normal of the plane out of A
  std::vector<Contact> contacts;  ///< from A to B
};

std::vector<FacePair> find_pairs(const PlacedPart& a, const PlacedPart& b, double clearance);

/// Pairs of holes of A and B with one axis along `normal`, as bolts leave them: how many distinct axes there are.
std::vector<Vector3d> common_hole_axes(const PlacedPart& a, const PlacedPart& b, const Vector3d& normal,
                                       double clearance);

/// How near the surfaces come to each other, by corners of one and triangles of the other; `within` where they stay
/// farther away than that.  Right to the deviation of the triangles from the shape.
double nearest(const PlacedPart& a, const PlacedPart& b, double within);

}  // namespace flexura::import::cad
