// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>

#include "mesh/model/disjoint_sets.hpp"
#include "mesh/model/samples.hpp"

namespace flexura::mesh {
Eigen::VectorXd jacobian_determinants(const Mesh& mesh, const CellBlock& block, Index cell,
                                      const Points& points) {
  const CellPoints x = points_of(mesh, block, cell);
  Eigen::VectorXd det(points.rows());
  for (Eigen::Index k = 0; k < points.rows(); ++k)
    det[k] = determinant(jacobian(x, evaluate_shape(block.type, points.row(k).transpose())));
  return det;
}

Volumes measure_volume(const Mesh& mesh) {
  Volumes total;
  if (mesh.points.rows() == 0) return total;
  const Eigen::Vector3d origin =
      mesh.points.colwise().mean().transpose();  // keeps second moments well scaled
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const CellBlock& block : mesh.solids) {
    const Samples samples(block.type, volume_quadrature(block.type));
    for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
      const CellPoints x = points_of(mesh, block, cell);
      for (std::size_t k = 0; k < samples.at.size(); ++k) {
        const double dV =
            determinant(jacobian(x, samples.at[k])) * samples.weights[static_cast<Eigen::Index>(k)];
        const Eigen::Vector3d r = x.transpose() * samples.at[k].N - origin;
        total.volume += dV;
        first += r * dV;
        second += r * r.transpose() * dV;
      }
    }
  }
  for (const CellBlock& block : mesh.shells) {
    const Samples samples(block.type, volume_quadrature(block.type));
    for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
      const CellPoints x = points_of(mesh, block, cell);
      for (std::size_t k = 0; k < samples.at.size(); ++k) {
        const Eigen::Matrix3d J = jacobian(x, samples.at[k]);
        const Eigen::Vector3d dA = J.col(0).cross(J.col(1)) * samples.weights[static_cast<Eigen::Index>(k)];
        const double dV = block.thickness[cell] * dA.norm();
        Eigen::Vector3d r = x.transpose() * samples.at[k].N - origin;
        if (!block.offset.empty()) r += block.offset[cell] * dA.normalized();
        total.volume += dV;
        first += r * dV;
        second += r * r.transpose() * dV;
      }
    }
  }
  if (total.volume == 0) return total;
  const Eigen::Vector3d c = first / total.volume;
  second -= total.volume * c * c.transpose();
  total.centroid = origin + c;
  total.inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  return total;
}

void extract_boundary(Mesh& mesh) {
  struct Entry {
    std::array<Index, 4> key;  // sorted corners, -1 first for triangles
    int block;
    Index cell;
    int face;
  };
  std::vector<Entry> entries;
  for (std::size_t b = 0; b < mesh.solids.size(); ++b) {
    const CellBlock& block = mesh.solids[b];
    const CellShape& shape = shape_of(block.type);
    entries.reserve(entries.size() + static_cast<std::size_t>(block.nodes.rows()) * shape.faces.size());
    for (Index cell = 0; cell < block.nodes.rows(); ++cell)
      for (std::size_t f = 0; f < shape.faces.size(); ++f) {
        const CellFace& face = shape.faces[f];
        Entry entry{{-1, -1, -1, -1}, static_cast<int>(b), cell, static_cast<int>(f)};
        const int n = shape_of(face.type).corners;
        for (int k = 0; k < n; ++k) entry.key[4 - n + k] = block.nodes(cell, face.nodes[k]);
        std::sort(entry.key.begin(), entry.key.end());
        entries.push_back(entry);
      }
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.key < b.key; });

  std::vector<Entry> outer;
  for (std::size_t i = 0; i < entries.size();) {
    std::size_t j = i + 1;
    while (j < entries.size() && entries[j].key == entries[i].key) ++j;
    if (j - i > 2)
      throw std::invalid_argument(
          "the face with corner nodes " + std::to_string(entries[i].key[1]) + ", " +
          std::to_string(entries[i].key[2]) + ", " + std::to_string(entries[i].key[3]) + " belongs to " +
          std::to_string(j - i) +
          " solid cells; at most two cells can share a face: look for cells given twice");
    if (j - i == 1) outer.push_back(entries[i]);
    i = j;
  }
  std::sort(outer.begin(), outer.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.block, a.cell, a.face) < std::tie(b.block, b.cell, b.face);
  });

  std::map<CellType, std::vector<const Entry*>> by_type;
  for (const Entry& entry : outer)
    by_type[shape_of(mesh.solids[entry.block].type).faces[entry.face].type].push_back(&entry);
  mesh.boundary.clear();
  mesh.boundary_face.clear();
  for (const auto& [type, list] : by_type) {
    CellBlock block;
    block.type = type;
    block.nodes.resize(static_cast<Eigen::Index>(list.size()), nodes_per_cell(type));
    for (std::size_t k = 0; k < list.size(); ++k) {
      const CellBlock& solid = mesh.solids[list[k]->block];
      const std::vector<int>& local = shape_of(solid.type).faces[list[k]->face].nodes;
      for (std::size_t n = 0; n < local.size(); ++n)
        block.nodes(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(n)) =
            solid.nodes(list[k]->cell, local[n]);
    }
    mesh.boundary.push_back(std::move(block));
  }
  for (const CellBlock& shell : mesh.shells)
    mesh.boundary.push_back({.type = shell.type, .nodes = shell.nodes});
}

Surface measure_surface(const Mesh& mesh, const std::vector<CellBlock>& faces) {
  Surface total;
  for (const CellBlock& block : faces) {
    const Samples samples(block.type, volume_quadrature(block.type));
    for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
      const CellPoints x = points_of(mesh, block, cell);
      for (std::size_t k = 0; k < samples.at.size(); ++k) {
        const Eigen::Matrix3d J = jacobian(x, samples.at[k]);
        const Eigen::Vector3d dA = J.col(0).cross(J.col(1)) * samples.weights[static_cast<Eigen::Index>(k)];
        total.area += dA.norm();
        total.centroid += (x.transpose() * samples.at[k].N) * dA.norm();
        total.normal += dA;
      }
    }
  }
  if (total.area > 0) {
    total.centroid /= total.area;
    total.normal /= total.area;
  }
  return total;
}

Eigen::VectorXd area_weights(const Mesh& mesh, const NodeSet& set, AreaWeights kind) {
  const auto n = static_cast<Eigen::Index>(set.nodes.size());
  if (set.faces.empty()) return Eigen::VectorXd::Constant(n, n > 0 ? 1.0 / static_cast<double>(n) : 0);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
  for (const CellBlock& block : set.faces) {
    const Samples samples(block.type, volume_quadrature(block.type));
    for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
      const CellPoints x = points_of(mesh, block, cell);
      Eigen::VectorXd own = Eigen::VectorXd::Zero(block.nodes.cols());
      double area = 0;
      for (std::size_t k = 0; k < samples.at.size(); ++k) {
        const Eigen::Matrix3d J = jacobian(x, samples.at[k]);
        const double dA = J.col(0).cross(J.col(1)).norm() * samples.weights[static_cast<Eigen::Index>(k)];
        const Eigen::VectorXd& N = samples.at[k].N;
        area += dA;
        own += kind == AreaWeights::consistent ? Eigen::VectorXd(N * dA)
                                               : Eigen::VectorXd(N.cwiseProduct(N) * dA);
      }
      if (kind == AreaWeights::positive) own *= area / own.sum();
      for (Eigen::Index k = 0; k < own.size(); ++k) {
        const auto at = std::lower_bound(set.nodes.begin(), set.nodes.end(), block.nodes(cell, k));
        if (at == set.nodes.end() || *at != block.nodes(cell, k))
          throw std::invalid_argument("node " + std::to_string(block.nodes(cell, k)) +
                                      " lies on a face of the set but is not among its nodes");
        weights[at - set.nodes.begin()] += own[k];
      }
    }
  }
  return weights;
}

Pieces find_pieces(const Mesh& mesh) {
  DisjointSets sets(static_cast<std::size_t>(mesh.n_nodes()));
  std::vector<char> used(sets.size(), 0);
  for (const auto* blocks : {&mesh.solids, &mesh.shells})
    for (const CellBlock& block : *blocks)
      for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
        for (Eigen::Index k = 0; k < block.nodes.cols(); ++k) {
          used[block.nodes(cell, k)] = 1;
          sets.join(block.nodes(cell, 0), block.nodes(cell, k));
        }
      }
  Pieces pieces;
  pieces.piece_of_node.assign(sets.size(), -1);
  for (Index k = 0; k < mesh.n_nodes(); ++k) {
    if (!used[k]) continue;
    const Index r = sets.of(k);
    if (r == k)
      pieces.piece_of_node[k] = pieces.count++;
    else
      pieces.piece_of_node[k] = pieces.piece_of_node[r];  // r < k
  }
  return pieces;
}

Index drop_unused_nodes(Mesh& mesh) {
  std::vector<Index> number(static_cast<std::size_t>(mesh.n_nodes()), -1);
  const auto mark = [&](const std::vector<CellBlock>& blocks) {
    for (const CellBlock& block : blocks)
      for (Eigen::Index k = 0; k < block.nodes.size(); ++k) number[block.nodes.data()[k]] = 0;
  };
  mark(mesh.solids);
  mark(mesh.shells);
  mark(mesh.boundary);
  for (const auto& [name, set] : mesh.sets) {
    mark(set.faces);
    for (const Index node : set.nodes) number[node] = 0;
  }
  Index next = 0;
  for (Index k = 0; k < mesh.n_nodes(); ++k) {
    if (number[k] < 0) continue;
    number[k] = next;
    mesh.points.row(next) = mesh.points.row(k).eval();
    if (!mesh.node_label.empty()) mesh.node_label[next] = mesh.node_label[k];
    ++next;
  }
  const Index dropped = mesh.n_nodes() - next;
  if (dropped == 0) return 0;
  mesh.points.conservativeResize(next, 3);
  if (!mesh.node_label.empty()) mesh.node_label.resize(static_cast<std::size_t>(next));
  const auto renumber = [&](std::vector<CellBlock>& blocks) {
    for (CellBlock& block : blocks)
      for (Eigen::Index k = 0; k < block.nodes.size(); ++k)
        block.nodes.data()[k] = number[block.nodes.data()[k]];
  };
  renumber(mesh.solids);
  renumber(mesh.shells);
  renumber(mesh.boundary);
  for (auto& [name, set] : mesh.sets) {
    renumber(set.faces);
    for (Index& node : set.nodes) node = number[node];
  }
  return dropped;
}

Eigen::Matrix<double, 2, 3> bounding_box(const Mesh& mesh) {
  Eigen::Matrix<double, 2, 3> box = Eigen::Matrix<double, 2, 3>::Zero();
  if (mesh.points.rows() > 0) {
    box.row(0) = mesh.points.colwise().minCoeff();
    box.row(1) = mesh.points.colwise().maxCoeff();
  }
  return box;
}

}  // namespace flexura::mesh
