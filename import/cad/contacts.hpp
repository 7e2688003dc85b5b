// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "import/cad/assembly.hpp"
#include "import/cad/freedom.hpp"

/// Where two placed parts touch, by what their faces are: a shaft in a bore, plane on plane, ball in socket, cone in cone. Touching means a
/// gap (or an overlap) of at most `clearance`, axes that coincide within it, planes that look at each other.
namespace flexura::import::cad {

/// Directions of faces that are to fit agree to this [rad]: CAD has them to 1e-9, a tenth of a degree is a draft.
constexpr double kSameDirection = 1e-3;

/// The faces of an instance in the world.
struct PlacedFace {
  mesh::FaceKind kind = mesh::FaceKind::other;
  int number = 0;  ///< from 1, in the part
  bool hole = false;
  double radius = 0.0;
  double lead = 0.0;             ///< of a thread's flank
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

/// By what a pair of faces is a thread (threads.hpp).
enum class ThreadSign { none, flanks, flanks_of_one, overlap, name };

struct FacePair {
  int face_a = 0, face_b = 0;  ///< numbers
  mesh::FaceKind kind = mesh::FaceKind::other;
  ThreadSign sign = ThreadSign::none;
  double lead = 0.0;        ///< of a thread [m], negative: left-hand
  bool shaft_in_a = false;  ///< cylinder, cone, sphere, thread: A has the convex face
  double radius = 0.0;      ///< of the convex face
  double gap = 0.0;         ///< [m], negative: overlap; a cone's across its surface
  double extent = 0.0;      ///< cylinder: length of the overlap [m]; plane, sphere: its area [m^2]
  Vector3d point, axis;     ///< middle of the contact; axis of the cylinder, normal of the plane out of A
  std::vector<Contact> contacts;  ///< from A to B

  bool is_thread() const { return sign != ThreadSign::none; }
};

std::vector<FacePair> find_pairs(const PlacedPart& a, const PlacedPart& b, double clearance);

/// Pairs of holes of A and B with one axis along `normal`, as bolts leave them: how many distinct axes there are.
std::vector<Vector3d> common_hole_axes(const PlacedPart& a, const PlacedPart& b, const Vector3d& normal,
                                       double clearance);

}  // namespace flexura::import::cad
