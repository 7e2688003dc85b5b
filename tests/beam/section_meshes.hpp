// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <vector>

#include "beam/section/solver.hpp"

/// Structured meshes of sections for tests.
namespace flexura::beam::testing {

/// Collects triangles whose corners are given in parameters; mid-side nodes lie at the middle of the
/// parameters, all nodes are mapped to (y, z) and merged by place.
class SectionMeshBuilder {
 public:
  using Map = std::function<Eigen::Vector2d(double, double)>;
  explicit SectionMeshBuilder(Map map, double tolerance) : map_(std::move(map)), tolerance_(tolerance) {}

  void add(const std::array<Eigen::Vector2d, 3>& corners, int ply = 0) {
    std::array<int, 6> nodes;
    for (int k = 0; k < 3; ++k) {
      nodes[k] = node(corners[k]);
      nodes[3 + k] = node(0.5 * (corners[k] + corners[(k + 1) % 3]));
    }
    triangles_.push_back(nodes);
    plies_.push_back(ply);
  }
  void add_quad(double u_0, double u_1, double v_0, double v_1, int ply = 0) {
    add({Eigen::Vector2d(u_0, v_0), Eigen::Vector2d(u_1, v_0), Eigen::Vector2d(u_1, v_1)}, ply);
    add({Eigen::Vector2d(u_0, v_0), Eigen::Vector2d(u_1, v_1), Eigen::Vector2d(u_0, v_1)}, ply);
  }
  /// The triangle (0, phi_0), (r, phi_0), (r, phi_1) in polar parameters: the centre lies on both rays.
  void add_fan(double r, double phi_0, double phi_1) {
    using V = Eigen::Vector2d;
    triangles_.push_back({node(V(0, phi_0)), node(V(r, phi_0)), node(V(r, phi_1)), node(V(0.5 * r, phi_0)),
                          node(V(r, 0.5 * (phi_0 + phi_1))), node(V(0.5 * r, phi_1))});
    plies_.push_back(0);
  }
  SectionMesh mesh() const {
    SectionMesh mesh;
    mesh.points.resize(points_.size(), 2);
    for (std::size_t k = 0; k < points_.size(); ++k) mesh.points.row(k) = points_[k];
    mesh.triangles.resize(triangles_.size(), 6);
    for (std::size_t k = 0; k < triangles_.size(); ++k)
      for (int j = 0; j < 6; ++j) mesh.triangles(k, j) = triangles_[k][j];
    mesh.ply = plies_;
    return mesh;
  }

 private:
  int node(const Eigen::Vector2d& parameter) {
    const Eigen::Vector2d p = map_(parameter.x(), parameter.y());
    const std::pair key{std::llround(p.x() / tolerance_), std::llround(p.y() / tolerance_)};
    const auto [it, added] = known_.insert({key, static_cast<int>(points_.size())});
    if (added) points_.push_back(p);
    return it->second;
  }
  Map map_;
  double tolerance_;
  std::map<std::pair<long long, long long>, int> known_;
  std::vector<Eigen::Vector2d> points_;
  std::vector<std::array<int, 6>> triangles_;
  std::vector<int> plies_;
};

inline Eigen::Vector2d same(double y, double z) {
  return {y, z};
}

inline std::vector<double> divide(double from, double to, int n) {
  std::vector<double> lines(n + 1);
  for (int k = 0; k <= n; ++k) lines[k] = from + (to - from) * k / n;
  return lines;
}

/// All cells of a grid for which `ply(y, z)` at the cell's middle is not negative.
inline SectionMesh grid_section(const std::vector<double>& y, const std::vector<double>& z,
                                const std::function<int(double, double)>& ply,
                                const SectionMeshBuilder::Map& map = same) {
  SectionMeshBuilder builder(map, 1e-7 * (y.back() - y.front()));
  for (std::size_t i = 0; i + 1 < y.size(); ++i)
    for (std::size_t j = 0; j + 1 < z.size(); ++j)
      if (const int p = ply(0.5 * (y[i] + y[i + 1]), 0.5 * (z[j] + z[j + 1])); p >= 0)
        builder.add_quad(y[i], y[i + 1], z[j], z[j + 1], p);
  return builder.mesh();
}

inline SectionMesh rectangle_section(double width, double height, int n_y, int n_z) {
  return grid_section(divide(-width / 2, width / 2, n_y), divide(-height / 2, height / 2, n_z),
                      [](double, double) { return 0; });
}

/// Ellipse with semi-axes a, b (and similar hole of the ratio q): rings of curved triangles.
inline SectionMesh ellipse_section(double a, double b, double q, int rings, int around) {
  SectionMeshBuilder builder(
      [a, b](double r, double phi) { return Eigen::Vector2d(a * r * std::cos(phi), b * r * std::sin(phi)); },
      1e-7 * a);
  for (int k = 0; k < around; ++k) {
    const double phi_0 = 2 * std::numbers::pi * k / around, phi_1 = 2 * std::numbers::pi * (k + 1) / around;
    for (int ring = 0; ring < rings; ++ring) {
      const double r_0 = q + (1 - q) * ring / rings, r_1 = q + (1 - q) * (ring + 1) / rings;
      if (r_0 > 0.0) {
        builder.add_quad(r_0, r_1, phi_0, phi_1);
      } else {
        builder.add_fan(r_1, phi_0, phi_1);
      }
    }
  }
  return builder.mesh();
}

}  // namespace flexura::beam::testing
