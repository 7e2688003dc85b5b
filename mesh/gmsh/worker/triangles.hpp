// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "mesh/gmsh/job.hpp"

// For the child process: what a surface of triangles encloses, and what its faces are.
namespace flexura::mesh {

struct Triangles {
  std::vector<Eigen::Vector3d> points;      ///< m
  std::vector<std::array<int, 3>> corners;  ///< counter-clockwise from outside once oriented
  std::vector<int> piece;   ///< of each triangle: its connected surface, 0 the outside; by orient()
  std::vector<int> origin;  ///< of each triangle: that of the file it is a part of; by orient()
};

/// Turns triangles so that neighbours agree and the outside is where no material is.  Throws std::runtime_error where the
/// surface is open, branches, has no volume, or bounds more than one body (beside another, or within a cavity).
void orient(Triangles& surface);

/// Halves edges longer than `longest` [m], the longest first, so that no triangle stays a needle (M. Rivara 1984: the longest edge
/// of all is that of both its triangles).  The surface stays where it is.  Stops at `most` triangles.
void refine(Triangles& surface, double longest, std::size_t most);

/// Volume, centroid, inertia about it (density 1) and box by the divergence theorem, of a closed surface.
SolidRecord describe_enclosed(const Triangles& surface);

/// Area, centroid, box and kind (plane, cylinder or other) of some of its triangles.
FaceRecord describe_facets(const Triangles& surface, const std::vector<int>& which, int number);

}  // namespace flexura::mesh
