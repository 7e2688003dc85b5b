// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/patches.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/disjoint_sets.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Vector3d;

Vector3d corner(const Mesh& mesh, const CellBlock& block, Index cell, int k) {
  return mesh.points.row(block.nodes(cell, k)).transpose();
}

/// Ericson, Real-Time Collision Detection (2005), section 5.1.5: by the region of barycentric coordinates.
double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return ap.norm();
  if (d3 >= 0 && d4 <= d3) return bp.norm();
  if (d6 >= 0 && d5 <= d6) return cp.norm();
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).norm();
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).norm();
  if (va <= 0 && d4 >= d3 && d5 >= d6) return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)).norm();
  return std::abs(ap.dot(ab.cross(ac).normalized()));
}

}  // namespace

Vector3d cell_normal(const Mesh& mesh, const CellBlock& block, Index cell) {
  const int n = shape_of(block.type).corners;
  const Vector3d a = corner(mesh, block, cell, 0), b = corner(mesh, block, cell, 1),
                 c = corner(mesh, block, cell, 2);
  if (n == 3) return (b - a).cross(c - a).normalized();
  return (c - a).cross(corner(mesh, block, cell, 3) - b).normalized();
}

double distance_to_cell(const Mesh& mesh, const CellBlock& block, Index cell, const Vector3d& point) {
  const int n = shape_of(block.type).corners;
  const Vector3d a = corner(mesh, block, cell, 0), b = corner(mesh, block, cell, 1),
                 c = corner(mesh, block, cell, 2);
  const double d = distance_to_triangle(point, a, b, c);
  return n == 3 ? d : std::min(d, distance_to_triangle(point, a, c, corner(mesh, block, cell, 3)));
}

std::size_t count_cells(const std::vector<CellBlock>& blocks) {
  std::size_t n = 0;
  for (const CellBlock& block : blocks) n += static_cast<std::size_t>(block.nodes.rows());
  return n;
}

void attach_faces_to_sets(Mesh& mesh) {
  for (auto& [name, set] : mesh.sets) {
    set.faces.clear();
    for (const CellBlock& block : mesh.boundary) {
      std::vector<Index> rows;
      for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
        bool inside = true;
        for (Eigen::Index k = 0; inside && k < block.nodes.cols(); ++k)
          inside = std::binary_search(set.nodes.begin(), set.nodes.end(), block.nodes(cell, k));
        if (inside) rows.push_back(cell);
      }
      if (rows.empty()) continue;
      CellBlock own;
      own.type = block.type;
      own.nodes = block.nodes(rows, Eigen::all);
      set.faces.push_back(std::move(own));
    }
  }
}

std::vector<Index> find_patches(const Mesh& mesh, double angle) {
  std::vector<Vector3d> normals;
  std::map<std::pair<Index, Index>, Index> first_at_edge;
  DisjointSets sets(static_cast<std::size_t>(count_cells(mesh.boundary)));
  const double cosine = std::cos(angle);
  for (const CellBlock& block : mesh.boundary) {
    const int n = shape_of(block.type).corners;
    for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
      const auto own = static_cast<Index>(normals.size());
      normals.push_back(cell_normal(mesh, block, cell));
      for (int k = 0; k < n; ++k) {
        const auto edge = std::minmax(block.nodes(cell, k), block.nodes(cell, (k + 1) % n));
        const auto [at, fresh] = first_at_edge.emplace(std::pair<Index, Index>(edge), own);
        if (fresh || normals[at->second].dot(normals[own]) < cosine) continue;
        sets.join(at->second, own);
      }
    }
  }
  std::vector<Index> patch(sets.size());
  Index count = 0;
  for (std::size_t k = 0; k < sets.size(); ++k) {
    const Index r = sets.of(static_cast<Index>(k));
    patch[k] = r == static_cast<Index>(k) ? ++count : patch[r];
  }
  return patch;
}

}  // namespace flexura::mesh
