// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/coincident.hpp"

#include <algorithm>

namespace flexura::mesh {

std::vector<std::pair<Index, Index>> coincident_nodes(
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>& points,
    std::vector<Index> nodes) {
  std::vector<std::pair<Index, Index>> out;
  if (nodes.empty()) return out;
  const Eigen::RowVector3d extent = points.colwise().maxCoeff() - points.colwise().minCoeff();
  const double near = 1e-6 * extent.norm();
  // Along the longest side; nodes in one place stand beside one another but for those of the same slice.
  int axis = 0;
  extent.maxCoeff(&axis);
  std::ranges::sort(nodes, [&](Index a, Index b) {
    const auto key = [&](Index n) { return std::pair(points(n, axis), n); };
    return key(a) < key(b);
  });
  // Within a slice by the next axis: regular meshes have many nodes in each.
  const int second = (axis + 1) % 3;
  for (std::size_t first = 0; first < nodes.size();) {
    std::size_t end = first + 1;
    while (end < nodes.size() && points(nodes[end], axis) - points(nodes[end - 1], axis) <= near) ++end;
    std::vector<Index> slice(nodes.begin() + static_cast<std::ptrdiff_t>(first),
                             nodes.begin() + static_cast<std::ptrdiff_t>(end));
    std::ranges::sort(slice, [&](Index a, Index b) { return points(a, second) < points(b, second); });
    for (std::size_t k = 0; k < slice.size(); ++k)
      for (std::size_t m = k + 1; m < slice.size(); ++m) {
        if (points(slice[m], second) - points(slice[k], second) > near) break;
        if ((points.row(slice[m]) - points.row(slice[k])).norm() <= near)
          out.emplace_back(std::min(slice[k], slice[m]), std::max(slice[k], slice[m]));
      }
    first = end;
  }
  std::ranges::sort(out, {}, [](const auto& pair) { return std::pair(pair.second, pair.first); });
  out.erase(
      std::unique(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.second == b.second; }),
      out.end());
  std::ranges::sort(out);
  return out;
}

}  // namespace flexura::mesh
