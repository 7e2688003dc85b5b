// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/nearest_interface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace flexura::study {
namespace {

using Eigen::Vector3d;

double distance_to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double s = length2 > 0.0 ? std::clamp(ab.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (p - a - s * ab).norm();
}

double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a);
  const auto inside = [&](const Vector3d& from, const Vector3d& to) {
    return (to - from).cross(p - from).dot(n) >= 0.0;
  };
  if (n.norm() > 0.0 && inside(a, b) && inside(b, c) && inside(c, a))
    return std::abs(n.dot(p - a)) / n.norm();
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

}  // namespace

std::string nearest_interface(const superelement::Superelement& se, const Vector3d& place) {
  const auto& surface = se.surface;
  if (static_cast<Eigen::Index>(surface.triangle_interface.size()) != surface.triangles.rows()) return "";
  const auto corner = [&](Eigen::Index t, int k) {
    return Vector3d(surface.vertices.row(surface.triangles(t, k)).transpose());
  };
  double least = std::numeric_limits<double>::infinity();
  int found = -1;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const double d = distance_to_triangle(place, corner(t, 0), corner(t, 1), corner(t, 2));
    if (d >= least) continue;
    least = d;
    found = surface.triangle_interface[static_cast<std::size_t>(t)];
  }
  return found < 0 ? "" : se.interfaces[static_cast<std::size_t>(found)].name;
}

}  // namespace flexura::study
