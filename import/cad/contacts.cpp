// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/contacts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "import/cad/round_contacts.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::cad {
namespace {

using mesh::FaceKind;
using Vector2d = Eigen::Vector2d;

constexpr double kAngle = kSameDirection;

bool boxes_meet(const Vector3d& low_a, const Vector3d& high_a, const Vector3d& low_b, const Vector3d& high_b,
                double slack) {
  return ((low_a.array() - slack) <= high_b.array()).all() &&
         ((low_b.array() - slack) <= high_a.array()).all();
}

using Polygon = std::vector<Vector2d>;

double area_of(const Polygon& p) {
  double twice = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vector2d &u = p[i], &v = p[(i + 1) % p.size()];
    twice += u.x() * v.y() - v.x() * u.y();
  }
  return 0.5 * twice;
}

// Sutherland and Hodgman; `clip` counter-clockwise.
Polygon clipped(Polygon subject, const Polygon& clip) {
  for (std::size_t e = 0; e < clip.size() && !subject.empty(); ++e) {
    const Vector2d &u = clip[e], d = clip[(e + 1) % clip.size()] - u;
    const auto side = [&](const Vector2d& x) { return d.x() * (x.y() - u.y()) - d.y() * (x.x() - u.x()); };
    Polygon kept;
    for (std::size_t i = 0; i < subject.size(); ++i) {
      const Vector2d &x = subject[i], &y = subject[(i + 1) % subject.size()];
      const double sx = side(x), sy = side(y);
      if (sx >= 0.0) kept.push_back(x);
      if ((sx > 0.0 && sy < 0.0) || (sx < 0.0 && sy > 0.0)) kept.push_back(x + (y - x) * (sx / (sx - sy)));
    }
    subject = std::move(kept);
  }
  return subject;
}

struct FlatTriangle {
  Polygon corners;
  Vector2d low, high;
};

std::vector<FlatTriangle> flat(const PlacedPart& part, const PlacedFace& face, const Matrix3d& R,
                               const Vector3d& o) {
  std::vector<FlatTriangle> list;
  for (const Eigen::Vector3i& t : face.face->triangles) {
    FlatTriangle f;
    for (int k = 0; k < 3; ++k) {
      const Vector3d x = R.transpose() * (part.vertices[static_cast<std::size_t>(t[k])] - o);
      f.corners.emplace_back(x.x(), x.y());
    }
    if (area_of(f.corners) < 0.0) std::swap(f.corners[1], f.corners[2]);
    f.low = f.corners[0].cwiseMin(f.corners[1]).cwiseMin(f.corners[2]);
    f.high = f.corners[0].cwiseMax(f.corners[1]).cwiseMax(f.corners[2]);
    list.push_back(std::move(f));
  }
  return list;
}

bool planes_touch(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                  double clearance, FacePair& pair) {
  if ((fa.normal + fb.normal).norm() > kAngle) return false;
  const double gap = fa.normal.dot(fb.point - fa.point);
  if (std::abs(gap) > clearance) return false;
  const Matrix3d R = mbs::frame_along(fa.normal);
  const auto flat_a = flat(a, fa, R, fa.point), flat_b = flat(b, fb, R, fa.point);
  double area = 0.0;
  Vector2d moment = Vector2d::Zero();
  std::vector<Vector2d> corners;
  for (const FlatTriangle& s : flat_a)
    for (const FlatTriangle& t : flat_b) {
      if ((s.low.array() > t.high.array()).any() || (t.low.array() > s.high.array()).any()) continue;
      const Polygon common = clipped(s.corners, t.corners);
      const double part = area_of(common);
      if (!(part > 0.0)) continue;
      area += part;
      Vector2d mean = Vector2d::Zero();
      for (const Vector2d& x : common) mean += x / static_cast<double>(common.size());
      moment += part * mean;
      corners.insert(corners.end(), common.begin(), common.end());
    }
  // Edges that touch, triangles' corners of round-off, are no seat.
  if (!(area > 1e-3 * std::min(fa.face->shape.area, fb.face->shape.area))) return false;
  constexpr int directions = 16;
  for (int k = 0; k < directions; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / directions;
    const Vector2d d(std::cos(angle), std::sin(angle));
    const auto far = std::ranges::max_element(corners, {}, [&](const Vector2d& x) { return x.dot(d); });
    pair.contacts.push_back({fa.point + R.leftCols<2>() * *far, fa.normal});
  }
  pair.kind = FaceKind::plane;
  pair.gap = gap;
  pair.extent = area;
  pair.axis = fa.normal;
  pair.point = fa.point + R.leftCols<2>() * (moment / area);
  return true;
}

bool spheres_touch(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                   double clearance, FacePair& pair) {
  if (fa.hole == fb.hole || (fa.point - fb.point).norm() > clearance) return false;
  const bool a_is_ball = !fa.hole;
  const PlacedFace &ball = a_is_ball ? fa : fb, &socket = a_is_ball ? fb : fa;
  const PlacedPart &ball_part = a_is_ball ? a : b, &socket_part = a_is_ball ? b : a;
  const double gap = socket.radius - ball.radius;
  if (std::abs(gap) > clearance) return false;
  const auto directions = [](const PlacedPart& part, const PlacedFace& face) {
    std::vector<Vector3d> list;
    for (const Eigen::Vector3i& t : face.face->triangles) {
      Vector3d mean = Vector3d::Zero();
      for (int k = 0; k < 3; ++k) mean += part.vertices[static_cast<std::size_t>(t[k])] - face.point;
      list.push_back(mean.normalized());
    }
    return list;
  };
  const auto of_ball = directions(ball_part, ball);
  // Triangles of the pictures are 12 degrees wide at most: where the ball has one within 15, it is there.
  const double near = std::cos(15.0 * std::numbers::pi / 180.0);
  for (const Vector3d& d : directions(socket_part, socket))
    if (std::ranges::any_of(of_ball, [&](const Vector3d& x) { return x.dot(d) > near; }))
      pair.contacts.push_back({ball.point + ball.radius * d, a_is_ball ? d : Vector3d(-d)});
  if (pair.contacts.size() < 3) return false;
  pair.kind = FaceKind::sphere;
  pair.shaft_in_a = a_is_ball;
  pair.radius = ball.radius;
  pair.gap = gap;
  pair.extent = std::min(fa.face->shape.area, fb.face->shape.area);
  pair.axis = Vector3d::UnitZ();
  pair.point = ball.point;
  return true;
}

}  // namespace

PlacedPart place(const Part& part, const Pose& X) {
  PlacedPart placed;
  placed.low.setConstant(std::numeric_limits<double>::infinity());
  placed.high = -placed.low;
  for (const Vector3d& v : part.surface.vertices) placed.vertices.push_back(X * v);
  for (const Face& face : part.faces) {
    const mesh::Face& s = face.shape;
    PlacedFace f{.kind = s.kind, .number = static_cast<int>(s.number), .hole = s.hole, .radius = s.radius};
    f.lead = face.lead;
    f.normal = X.R * s.normal;
    f.axis = X.R * s.axis;
    f.point = X * (s.kind == FaceKind::plane ? s.centroid : s.axis_point);
    f.low.setConstant(std::numeric_limits<double>::infinity());
    f.high = -f.low;
    for (const Eigen::Vector3i& t : face.triangles)
      for (int k = 0; k < 3; ++k) {
        f.low = f.low.cwiseMin(placed.vertices[static_cast<std::size_t>(t[k])]);
        f.high = f.high.cwiseMax(placed.vertices[static_cast<std::size_t>(t[k])]);
      }
    f.face = &face;
    placed.low = placed.low.cwiseMin(f.low);
    placed.high = placed.high.cwiseMax(f.high);
    placed.faces.push_back(std::move(f));
  }
  return placed;
}

std::vector<FacePair> find_pairs(const PlacedPart& a, const PlacedPart& b, double clearance) {
  std::vector<FacePair> pairs;
  if (!boxes_meet(a.low, a.high, b.low, b.high, clearance)) return pairs;
  for (const PlacedFace& fa : a.faces)
    for (const PlacedFace& fb : b.faces) {
      if (fa.kind != fb.kind || !boxes_meet(fa.low, fa.high, fb.low, fb.high, clearance)) continue;
      FacePair pair{.face_a = fa.number, .face_b = fb.number};
      const bool touch = fa.kind == FaceKind::cylinder ? cylinders_touch(a, fa, b, fb, clearance, pair)
                         : fa.kind == FaceKind::plane  ? planes_touch(a, fa, b, fb, clearance, pair)
                         : fa.kind == FaceKind::sphere ? spheres_touch(a, fa, b, fb, clearance, pair)
                         : fa.kind == FaceKind::cone   ? cones_touch(a, fa, b, fb, clearance, pair)
                                                       : false;
      if (touch) pairs.push_back(std::move(pair));
    }
  return pairs;
}

std::vector<Vector3d> common_hole_axes(const PlacedPart& a, const PlacedPart& b, const Vector3d& normal,
                                       double clearance) {
  std::vector<Vector3d> axes;
  const auto across = [&](const Vector3d& x) { return Vector3d(x - normal * normal.dot(x)); };
  for (const PlacedFace& fa : a.faces)
    for (const PlacedFace& fb : b.faces) {
      if (fa.kind != FaceKind::cylinder || fb.kind != FaceKind::cylinder || !fa.hole || !fb.hole) continue;
      if (fa.axis.cross(normal).norm() > kAngle || fb.axis.cross(normal).norm() > kAngle) continue;
      if (across(fa.point - fb.point).norm() > clearance) continue;
      // They meet at the plane: their reaches along the normal touch.
      const double slack = clearance + 1e-6;
      if (!boxes_meet(fa.low, fa.high, fb.low, fb.high, slack)) continue;
      const Vector3d axis = across(fa.point);
      if (std::ranges::none_of(axes, [&](const Vector3d& x) { return (x - axis).norm() < clearance; }))
        axes.push_back(axis);
    }
  return axes;
}

}  // namespace flexura::import::cad
