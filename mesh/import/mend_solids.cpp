// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "mesh/import/builder.hpp"
#include "mesh/model/cells/cell.hpp"
#include "mesh/model/cells/record.hpp"
#include "mesh/model/geometry.hpp"

namespace flexura::mesh {
namespace {

// The nodes of a cell in the order of its mirror image: r and s of the reference cell change places, which each of them is
// symmetric in.
std::vector<int> mirrored_order(CellType type) {
  const CellRecord::Points& x = record_of(type).nodes;
  std::vector<int> order;
  for (Eigen::Index k = 0; k < x.rows(); ++k)
    for (Eigen::Index other = 0; other < x.rows(); ++other)
      if ((x.row(other) - Eigen::RowVector3d(x(k, 1), x(k, 0), x(k, 2))).norm() < 1e-9)
        order.push_back(static_cast<int>(other));
  return order;
}

}  // namespace

void ModelBuilder::mend_solids(ImportedModel& model) {
  Mesh one;  // of a cell alone
  const auto least_at = [&](const Cell& cell, const Quadrature& at) {
    const auto n = static_cast<Index>(cell.nodes.size());
    one.points.resize(n, 3);
    CellBlock block{.type = cell.type};
    block.nodes.resize(1, n);
    for (Index k = 0; k < n; ++k) {
      one.points.row(k) = place(cell.nodes[static_cast<std::size_t>(k)]).transpose();
      block.nodes(0, k) = k;
    }
    return jacobian_determinants(one, block, 0, at.points).minCoeff();
  };
  const auto least = [&](const Cell& cell) {
    return std::min(least_at(cell, stiffness_quadrature(cell.type)),
                    least_at(cell, volume_quadrature(cell.type)));
  };
  Unused mirrored, straightened;
  std::vector<std::string> inside_out;
  for (Cell& cell : cells_) {
    if (dimension_of(cell.type) != 3) continue;
    if (least(cell) > 0) continue;
    const std::string type = name_of(cell.type);
    Cell other = cell;
    const std::vector<int> order = mirrored_order(cell.type);
    for (std::size_t k = 0; k < order.size(); ++k)
      other.nodes[k] = cell.nodes[static_cast<std::size_t>(order[k])];
    if (least(other) > 0) {
      cell = std::move(other);
      mirrored.add(
          fmt::format("element of type {} left-handed by its numbering: numbered the other way round", type),
          cell.where);
      continue;
    }
    // Edges that bulge too far: their middles go to the middle, where the corners alone make a sound cell.
    const std::vector<std::array<int, 2>>& edges = shape_of(cell.type).edges;
    const auto corners = static_cast<std::size_t>(shape_of(cell.type).corners);
    std::vector<std::pair<Index, Eigen::Vector3d>> before;
    for (std::size_t e = 0; e < edges.size() && cell.nodes.size() >= corners + edges.size(); ++e) {
      const Index middle = cell.nodes[corners + e];
      before.emplace_back(middle, place(middle));
      move(middle, 0.5 * (place(cell.nodes[static_cast<std::size_t>(edges[e][0])]) +
                          place(cell.nodes[static_cast<std::size_t>(edges[e][1])])));
    }
    if (!before.empty() && least(cell) > 0) {
      straightened.add(
          fmt::format("element of type {} turned inside out by its curved edges: they are made straight",
                      type),
          cell.where);
      continue;
    }
    for (const auto& [node, x] : before) move(node, x);
    inside_out.push_back(
        fmt::format("{}: element {} ({}) is turned inside out: det J <= 0 at an integration point",
                    cell.where.text(), cell.label, type));
  }
  for (const Unused* done : {&mirrored, &straightened})
    for (const std::string& remark : done->remarks()) model.warnings.push_back(remark);
  if (inside_out.empty()) return;
  std::string text = inside_out.front();
  if (inside_out.size() > 1) text += fmt::format("; so are {} more", inside_out.size() - 1);
  throw std::invalid_argument(text);
}

}  // namespace flexura::mesh
