// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/superelement/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace flexura::reduce {

namespace {

using mesh::CellType;
using mesh::Index;

/// Triangles and outline of a boundary cell in its local nodes.
struct Split {
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 2>> outline;  ///< segments, in order of the cell's edges
  int segments_per_edge;
};

const Split& split_of(CellType type) {
  static const std::map<CellType, Split> splits = {
      {CellType::tri3, {{{0, 1, 2}}, {{0, 1}, {1, 2}, {2, 0}}, 1}},
      {CellType::tri6,
       {{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}, {{0, 3}, {3, 1}, {1, 4}, {4, 2}, {2, 5}, {5, 0}}, 2}},
      {CellType::quad4, {{{0, 1, 2}, {0, 2, 3}}, {{0, 1}, {1, 2}, {2, 3}, {3, 0}}, 1}},
      {CellType::quad8,
       {{{0, 4, 7}, {4, 1, 5}, {5, 2, 6}, {6, 3, 7}, {4, 5, 7}, {5, 6, 7}},
        {{0, 4}, {4, 1}, {1, 5}, {5, 2}, {2, 6}, {6, 3}, {3, 7}, {7, 0}},
        2}},
      {CellType::quad9,
       {{{0, 4, 8}, {0, 8, 7}, {4, 1, 8}, {1, 5, 8}, {5, 2, 8}, {2, 6, 8}, {6, 3, 8}, {3, 7, 8}},
        {{0, 4}, {4, 1}, {1, 5}, {5, 2}, {2, 6}, {6, 3}, {3, 7}, {7, 0}},
        2}},
  };
  const auto found = splits.find(type);
  if (found == splits.end()) throw std::logic_error("a boundary cell that is no face");
  return found->second;
}

Eigen::Vector3d normal_of(const mesh::Mesh& mesh, const auto& nodes) {
  const Eigen::Vector3d a = mesh.points.row(nodes[0]), b = mesh.points.row(nodes[1]),
                        c = mesh.points.row(nodes[2]);
  return (b - a).cross(c - a).normalized();
}

/// The two cells at an edge, to decide whether it is a feature.
struct EdgeUse {
  int count = 0;
  Index face = -1;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  bool feature = false;
};

}  // namespace

SurfacePicture make_surface(const mesh::Mesh& mesh,
                            const std::vector<std::vector<mesh::Index>>& interface_nodes) {
  SurfacePicture picture;
  std::vector<int> vertex_of(mesh.n_nodes(), -1);
  for (const mesh::CellBlock& block : mesh.boundary) {
    for (Index c = 0; c < block.nodes.rows(); ++c) {
      for (Index n = 0; n < block.nodes.cols(); ++n) vertex_of[block.nodes(c, n)] = 0;
    }
  }
  for (Index node = 0; node < mesh.n_nodes(); ++node) {
    if (vertex_of[node] < 0) continue;
    vertex_of[node] = static_cast<int>(picture.nodes.size());
    picture.nodes.push_back(node);
  }
  picture.surface.vertices.resize(picture.nodes.size(), 3);
  for (std::size_t v = 0; v < picture.nodes.size(); ++v) {
    picture.surface.vertices.row(v) = mesh.points.row(picture.nodes[v]);
  }

  const double cos_feature = std::cos(30.0 * std::numbers::pi / 180.0);
  std::map<std::array<int, 2>, EdgeUse> edges;
  std::vector<std::array<int, 3>> triangles;
  std::size_t cell = 0;
  for (const mesh::CellBlock& block : mesh.boundary) {
    const Split& split = split_of(block.type);
    for (Index c = 0; c < block.nodes.rows(); ++c, ++cell) {
      const auto nodes = block.nodes.row(c);
      for (const auto& t : split.triangles) {
        triangles.push_back({vertex_of[nodes[t[0]]], vertex_of[nodes[t[1]]], vertex_of[nodes[t[2]]]});
      }
      const Index face = mesh.boundary_face.empty() ? -1 : mesh.boundary_face[cell];
      const Eigen::Vector3d normal = normal_of(mesh, nodes);
      for (const auto& segment : split.outline) {
        std::array<int, 2> key{vertex_of[nodes[segment[0]]], vertex_of[nodes[segment[1]]]};
        std::sort(key.begin(), key.end());
        EdgeUse& use = edges[key];
        if (use.count++ == 0) {
          use.face = face;
          use.normal = normal;
        } else {
          use.feature = face >= 0 ? face != use.face : normal.dot(use.normal) < cos_feature;
        }
      }
    }
  }

  picture.surface.triangles.resize(triangles.size(), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) picture.surface.triangles(t, k) = triangles[t][k];
  }
  std::vector<std::array<int, 2>> features;
  for (const auto& [key, use] : edges) {
    if (use.feature || use.count == 1) features.push_back(key);
  }
  picture.surface.edges.resize(features.size(), 2);
  for (std::size_t e = 0; e < features.size(); ++e) {
    picture.surface.edges.row(e) << features[e][0], features[e][1];
  }

  picture.surface.triangle_interface.assign(triangles.size(), -1);
  for (std::size_t k = 0; k < interface_nodes.size(); ++k) {
    std::vector<bool> inside(picture.nodes.size(), false);
    for (const Index node : interface_nodes[k]) {
      if (vertex_of[node] >= 0) inside[vertex_of[node]] = true;
    }
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto& [a, b, c] = triangles[t];
      if (inside[a] && inside[b] && inside[c]) picture.surface.triangle_interface[t] = static_cast<int>(k);
    }
  }
  return picture;
}

}  // namespace flexura::reduce
