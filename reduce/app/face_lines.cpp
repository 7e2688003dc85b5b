// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/face_lines.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace flexura::reduce {

namespace {

using Eigen::Vector3d;

/// Of the part.
double diagonal_of(const std::vector<mesh::Face>& faces) {
  Eigen::Matrix<double, 2, 3> box = faces.front().box;
  for (const mesh::Face& f : faces) {
    box.row(0) = box.row(0).cwiseMin(f.box.row(0));
    box.row(1) = box.row(1).cwiseMax(f.box.row(1));
  }
  return (box.row(1) - box.row(0)).norm();
}

/// Whether the rule of `face` (mesh/model/select.hpp), without an extent, takes `other` as well.  With twice its tolerances: in
/// doubt a rule that says more is written.
bool takes(const mesh::Face& face, const mesh::Face& other, double diagonal) {
  constexpr double kAngle = std::numbers::pi / 180, kRelative = 0.01, kPlane = 2e-4;
  if (face.kind != other.kind) return false;
  if (face.kind == mesh::FaceKind::plane)
    return std::abs(face.normal.dot(other.normal)) > std::cos(kAngle) &&
           std::abs(face.normal.dot(other.centroid - face.centroid)) <= kPlane * diagonal;
  return std::abs(face.axis.dot(other.axis)) > std::cos(kAngle) &&
         (other.axis_point - face.axis_point).cross(face.axis).norm() <= kRelative * face.radius &&
         std::abs(other.radius - face.radius) <= kRelative * face.radius;
}

double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a);
  if (n.squaredNorm() > 0.0) {
    const double u = (b - a).cross(p - a).dot(n), v = (c - b).cross(p - b).dot(n),
                 w = (a - c).cross(p - c).dot(n);
    if (u >= 0.0 && v >= 0.0 && w >= 0.0) return std::abs((p - a).dot(n)) / n.norm();
  }
  const auto to_edge = [&](const Vector3d& q, const Vector3d& r) {
    const double s = (r - q).squaredNorm();
    return (p - q - (s > 0.0 ? std::clamp((p - q).dot(r - q) / s, 0.0, 1.0) : 0.0) * (r - q)).norm();
  };
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

/// The middle of one of the largest triangles of the face, the one farthest from all other faces, with that distance.
std::pair<Vector3d, double> point_on(mesh::Index number, const mesh::FacesPicture& picture) {
  constexpr std::size_t kTried = 12;
  std::vector<std::pair<double, Vector3d>> middles;
  const auto corner = [&](std::size_t t, int k) -> const Vector3d& {
    return picture.vertices[static_cast<std::size_t>(picture.triangles[t][k])];
  };
  for (std::size_t t = 0; t < picture.triangles.size(); ++t)
    if (picture.face[t] == number)
      middles.emplace_back((corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm(),
                           (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3.0);
  std::ranges::sort(middles, [](const auto& a, const auto& b) { return a.first > b.first; });
  middles.resize(std::min(middles.size(), kTried));
  std::pair<Vector3d, double> best{Vector3d::Zero(), -1.0};
  for (const auto& [area, p] : middles) {
    double nearest = std::numeric_limits<double>::max();
    for (std::size_t t = 0; t < picture.triangles.size() && nearest > best.second; ++t)
      if (picture.face[t] != number)
        nearest = std::min(nearest, distance_to_triangle(p, corner(t, 0), corner(t, 1), corner(t, 2)));
    if (nearest > best.second) best = {p, nearest};
  }
  return best;
}

}  // namespace

std::vector<mesh::Index> others_of(const mesh::Face& face, const std::vector<mesh::Face>& faces) {
  std::vector<mesh::Index> out;
  if (face.kind != mesh::FaceKind::cylinder) return out;
  constexpr double kSame = 1e-5;  // of the radius: what CAD programs write of one and the same axis
  double sweep = face.sweep;
  for (const mesh::Face& f : faces) {
    if (f.number == face.number || f.kind != face.kind || f.hole != face.hole || f.solid != face.solid)
      continue;
    if (std::abs(f.radius - face.radius) > kSame * face.radius || f.axis.cross(face.axis).norm() > kSame ||
        (f.axis_point - face.axis_point).norm() > kSame * face.radius ||
        std::abs(f.length - face.length) > kSame * face.radius)
      continue;
    out.push_back(f.number);
    sweep += f.sweep;
  }
  if (sweep < 1.5 * std::numbers::pi) out.clear();  // fillets at the two sides of a slot
  return out;
}

std::optional<std::string> surface_lines(const mesh::Face& face, const std::vector<mesh::Face>& faces) {
  if (face.kind != mesh::FaceKind::cylinder && face.kind != mesh::FaceKind::plane) return std::nullopt;
  std::vector<mesh::Index> group = others_of(face, faces);
  group.push_back(face.number);
  const mesh::Face& first = *std::ranges::find(faces, std::ranges::min(group), &mesh::Face::number);
  const double diagonal = diagonal_of(faces), half = 0.5 * first.length;
  bool is_in_line = false;
  for (const mesh::Face& other : faces) {
    if (std::ranges::find(group, other.number) != group.end() || !takes(first, other, diagonal)) continue;
    // An extent judges the middles of faces.
    if (first.kind == mesh::FaceKind::plane ||
        std::abs(first.axis.dot(other.axis_point - first.axis_point)) <= half + 1e-6 * diagonal)
      return std::nullopt;
    is_in_line = true;
  }
  std::string lines = mesh::selection_lines(first);
  if (is_in_line) lines += fmt::format("extent = [\"{:.9g} mm\", \"{:.9g} mm\"]\n", -1e3 * half, 1e3 * half);
  std::ranges::sort(group);
  if (group.size() > 1) lines += fmt::format("# faces {} together\n", fmt::join(group, " and "));
  return lines;
}

std::vector<std::string> face_lines(const std::vector<mesh::Face>& faces, const mesh::FacesPicture& picture) {
  std::vector<std::string> out;
  for (const mesh::Face& face : faces) {
    if (auto lines = surface_lines(face, faces)) {
      out.push_back(*std::move(lines));
      continue;
    }
    const auto [p, apart] = point_on(face.number, picture);
    const Vector3d mm = 1e3 * p;
    out.push_back(apart > 1e-5 * diagonal_of(faces)
                      ? fmt::format("by = \"near\"\npoint = [\"{:.9g} mm\", \"{:.9g} mm\", \"{:.9g} mm\"]\n",
                                    mm.x(), mm.y(), mm.z())
                      : fmt::format("by = \"faces\"\nfaces = [{}]\n# another face lies on it: this number "
                                    "changes with the drawing\n",
                                    face.number));
  }
  return out;
}

}  // namespace flexura::reduce
