// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

/// Shells for tests: a grid of nx by ny quadrilaterals (or twice as many triangles) over (0, 1) x (0, 1), carried
/// into space.
namespace flexura::reduce::testing {

struct ShellMesh {
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> points;
  std::vector<std::vector<int>> cells;
  int nx = 0, ny = 0;

  int node(int i, int j) const { return i + (nx + 1) * j; }
  std::vector<int> nodes_where(const std::function<bool(const Eigen::Vector3d&)>& is) const {
    std::vector<int> out;
    for (int k = 0; k < points.rows(); ++k)
      if (is(points.row(k).transpose())) out.push_back(k);
    return out;
  }
};

inline ShellMesh shell_grid(int nx, int ny, bool triangles,
                            const std::function<Eigen::Vector3d(double, double)>& place) {
  ShellMesh mesh;
  mesh.nx = nx, mesh.ny = ny;
  mesh.points.resize((nx + 1) * (ny + 1), 3);
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i)
      mesh.points.row(mesh.node(i, j)) =
          place(static_cast<double>(i) / nx, static_cast<double>(j) / ny).transpose();
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const int a = mesh.node(i, j), b = mesh.node(i + 1, j), c = mesh.node(i + 1, j + 1),
                d = mesh.node(i, j + 1);
      if (!triangles) {
        mesh.cells.push_back({a, b, c, d});
      } else if ((i + j) % 2 == 0) {
        mesh.cells.push_back({a, b, c});
        mesh.cells.push_back({a, c, d});
      } else {
        mesh.cells.push_back({a, b, d});
        mesh.cells.push_back({b, c, d});
      }
    }
  return mesh;
}

}  // namespace flexura::reduce::testing
