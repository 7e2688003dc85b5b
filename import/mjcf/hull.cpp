// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/mjcf/hull.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <stdexcept>

namespace flexura::import::mjcf {
namespace {

struct Facet {
  Eigen::Vector3i corners;
  Vector3d normal;
  double offset;
};

}  // namespace

// Point by point: facets that see the point go, its cone over their rim comes (Clarkson and Shor's incremental hull without its conflict
// lists: meshes for inertias have some thousand points on their hulls).
Surface convex_hull(const std::vector<Vector3d>& points) {
  const auto at = [&](int i) -> const Vector3d& { return points[static_cast<std::size_t>(i)]; };
  const int n = static_cast<int>(points.size());
  const auto farthest = [&](const auto& measure) {
    int best = 0;
    for (int i = 1; i < n; ++i)
      if (measure(at(i)) > measure(at(best))) best = i;
    return best;
  };
  const auto flat = [] {
    throw std::invalid_argument(
        "its points lie in one plane and enclose no volume; give the body an <inertial>");
  };
  if (n < 4) flat();
  const int a = farthest([](const Vector3d& x) { return -x.x(); });
  const int b = farthest([&](const Vector3d& x) { return (x - at(a)).squaredNorm(); });
  const Vector3d ab = at(b) - at(a);
  const double size = ab.norm();
  const int c = farthest([&](const Vector3d& x) { return ab.cross(x - at(a)).squaredNorm(); });
  const Vector3d normal = ab.cross(at(c) - at(a));
  const int d = farthest([&](const Vector3d& x) { return std::abs(normal.dot(x - at(a))); });
  const double eps = 1e-10 * size;  // what is nearer to a facet lies in it
  if (!(normal.norm() > eps * size) || !(std::abs(normal.normalized().dot(at(d) - at(a))) > eps)) flat();
  const Vector3d inside = 0.25 * (at(a) + at(b) + at(c) + at(d));
  std::vector<Facet> facets;
  const auto add = [&](int i, int j, int k) {
    Vector3d m = (at(j) - at(i)).cross(at(k) - at(i)).normalized();
    if (m.dot(inside - at(i)) > 0.0) {
      std::swap(j, k);
      m = -m;
    }
    facets.push_back({{i, j, k}, m, m.dot(at(i))});
  };
  add(a, b, c);
  add(a, b, d);
  add(a, c, d);
  add(b, c, d);
  for (int p = 0; p < n; ++p) {
    std::map<std::pair<int, int>, int> rim;
    const auto sees = [&](const Facet& f) { return f.normal.dot(at(p)) > f.offset + eps; };
    for (const Facet& f : facets) {
      if (!sees(f)) continue;
      for (int k = 0; k < 3; ++k) {
        const int i = f.corners[k], j = f.corners[(k + 1) % 3];
        if (const auto other = rim.find({j, i}); other != rim.end())
          rim.erase(other);
        else
          rim[{i, j}] = 1;
      }
    }
    if (rim.empty()) continue;
    std::erase_if(facets, sees);
    for (const auto& [edge, unused] : rim) add(edge.first, edge.second, p);
  }
  Surface hull;
  std::map<int, int> number;
  for (const Facet& f : facets) {
    Eigen::Vector3i t;
    for (int k = 0; k < 3; ++k) {
      const auto [found, is_new] = number.emplace(f.corners[k], static_cast<int>(hull.vertices.size()));
      if (is_new) hull.vertices.push_back(at(f.corners[k]));
      t[k] = found->second;
    }
    hull.triangles.push_back(t);
  }
  return hull;
}

}  // namespace flexura::import::mjcf
