// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/shell_sides.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <stdexcept>

#include "mesh/model/cells/cell.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Vector3d;

struct Cell {
  std::size_t block;
  Eigen::Index row;
  std::vector<Index> corners;
  Vector3d area, middle;  ///< along the normal
  bool turned = false, seen = false;
  double sign() const { return turned ? -1.0 : 1.0; }
};

std::vector<Index> corners_of(const CellBlock& block, Eigen::Index row) {
  std::vector<Index> out;
  for (int k = 0; k < shape_of(block.type).corners; ++k) out.push_back(block.nodes(row, k));
  return out;
}

std::vector<Index> sorted(std::vector<Index> nodes) {
  std::ranges::sort(nodes);
  return nodes;
}

std::vector<Cell> shells_among(const Mesh& mesh, std::span<const CellBlock> faces) {
  std::set<std::vector<Index>> shells;
  for (const CellBlock& block : mesh.shells)
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row) shells.insert(sorted(corners_of(block, row)));
  std::vector<Cell> out;
  for (std::size_t b = 0; b < faces.size(); ++b)
    for (Eigen::Index row = 0; row < faces[b].nodes.rows(); ++row) {
      Cell cell{.block = b, .row = row, .corners = corners_of(faces[b], row), .area = {}, .middle = {}};
      if (!shells.contains(sorted(cell.corners))) continue;
      const auto at = [&](std::size_t k) -> Vector3d { return mesh.points.row(cell.corners[k]).transpose(); };
      const std::size_t last = cell.corners.size() - 1;
      cell.area = last == 2 ? Vector3d(0.5 * (at(1) - at(0)).cross(at(2) - at(0)))
                            : Vector3d(0.5 * (at(2) - at(0)).cross(at(3) - at(1)));
      cell.middle = Vector3d::Zero();
      for (std::size_t k = 0; k <= last; ++k) cell.middle += at(k) / static_cast<double>(last + 1);
      out.push_back(std::move(cell));
    }
  return out;
}

// An edge: who has it, and whether in the direction of rising node numbers.
using Edges = std::map<std::array<Index, 2>, std::vector<std::pair<std::size_t, bool>>>;

Edges edges_of(const std::vector<Cell>& cells) {
  Edges edges;
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (std::size_t k = 0; k < cells[c].corners.size(); ++k) {
      const Index a = cells[c].corners[k], b = cells[c].corners[(k + 1) % cells[c].corners.size()];
      edges[{std::min(a, b), std::max(a, b)}].emplace_back(c, a < b);
    }
  return edges;
}

// All that hang together with the first one, turned as it is.
std::vector<std::size_t> piece_from(std::size_t first, std::vector<Cell>& cells, const Edges& edges) {
  std::vector<std::size_t> piece{first};
  cells[first].seen = true;
  for (std::size_t at = 0; at < piece.size(); ++at) {
    const Cell& cell = cells[piece[at]];
    for (std::size_t k = 0; k < cell.corners.size(); ++k) {
      const Index a = cell.corners[k], b = cell.corners[(k + 1) % cell.corners.size()];
      const auto& has = edges.at({std::min(a, b), std::max(a, b)});
      if (has.size() != 2) continue;  // a rim, or a joint of several sheets
      const bool own = has[0].first == piece[at];
      const auto& [other, rises] = has[own ? 1 : 0];
      // Neighbours of one side go along their edge in opposite directions.
      const bool turned = (rises == has[own ? 0 : 1].second) != cell.turned;
      if (!cells[other].seen) {
        cells[other].seen = true, cells[other].turned = turned;
        piece.push_back(other);
      } else if (cells[other].turned != turned) {
        throw std::invalid_argument(
            "the shells that it pushes on have one side only (a Moebius strip); push on a part of them");
      }
    }
  }
  return piece;
}

// Along `side` > 0, against it < 0.
double looks_along(const std::vector<std::size_t>& piece, const std::vector<Cell>& cells,
                   const Vector3d& side) {
  double sum = 0.0, area = 0.0, farthest = -HUGE_VAL, there = 0.0;
  for (const std::size_t c : piece) {
    const double along = cells[c].sign() * cells[c].area.dot(side);
    sum += along, area += cells[c].area.norm();
    if (std::abs(along) > 0.1 * cells[c].area.norm() && cells[c].middle.dot(side) > farthest)
      farthest = cells[c].middle.dot(side), there = along;
  }
  return std::abs(sum) > 1e-3 * area ? sum : there;
}

}  // namespace

ShellSides shells_of_one_side(const Mesh& mesh, std::span<const CellBlock> faces,
                              const std::optional<Vector3d>& side) {
  std::vector<Cell> cells = shells_among(mesh, faces);
  const Edges edges = edges_of(cells);
  for (std::size_t first = 0; first < cells.size(); ++first) {
    if (cells[first].seen) continue;
    const std::vector<std::size_t> piece = piece_from(first, cells, edges);
    double turned = 0.0, area = 0.0;
    for (const std::size_t c : piece) {
      area += cells[c].area.norm();
      if (cells[c].turned) turned += cells[c].area.norm();
    }
    bool others = turned > 0.5 * area;
    if (side) {
      const double along = looks_along(piece, cells, side->normalized());
      if (along == 0.0)
        throw std::invalid_argument(
            "its side lies in the shells that it pushes on; give a direction that leads away from them");
      others = along < 0.0;
    } else if (std::min(turned, area - turned) > 0.25 * area) {
      throw std::invalid_argument(fmt::format(
          "the shells that it pushes on are numbered both ways, so that {:.3g} of {:.3g} m^2 would be pushed "
          "the other way; give the side that is pushed, side = [x, y, z], as the direction to which it looks",
          std::min(turned, area - turned), area));
    }
    if (others)
      for (const std::size_t c : piece) cells[c].turned = !cells[c].turned;
  }
  ShellSides out;
  for (const CellBlock& block : faces) out.turned.emplace_back(block.nodes.rows(), 0);
  for (const Cell& cell : cells) {
    out.turned[cell.block][static_cast<std::size_t>(cell.row)] = cell.turned;
    out.n_turned += cell.turned, ++out.n_shells;
  }
  return out;
}

std::vector<CellBlock> cells_where(std::span<const CellBlock> faces, const ShellSides& sides, bool turned) {
  std::vector<CellBlock> out;
  for (std::size_t b = 0; b < faces.size(); ++b) {
    CellBlock block{.type = faces[b].type, .variant = faces[b].variant};
    std::vector<Eigen::Index> rows;
    for (Eigen::Index row = 0; row < faces[b].nodes.rows(); ++row)
      if ((sides.turned[b][static_cast<std::size_t>(row)] != 0) == turned) rows.push_back(row);
    block.nodes = faces[b].nodes(rows, Eigen::all);
    out.push_back(std::move(block));
  }
  return out;
}

}  // namespace flexura::mesh
