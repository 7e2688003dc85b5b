// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/contacts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "mbs/base/math/rotation.hpp"

namespace flexura::import::cad {
namespace {

using mesh::FaceKind;
using Vector2d = Eigen::Vector2d;

// Directions of faces that are to fit agree to this [rad]: CAD has them to 1e-9, a tenth of a degree is a draft.
constexpr double kAngle = 1e-3;
constexpr int kBins = 72;  // of the circle, 5 degrees each

bool boxes_meet(const Vector3d& low_a, const Vector3d& high_a, const Vector3d& low_b, const Vector3d& high_b,
                double slack) {
  return ((low_a.array() - slack) <= high_b.array()).all() &&
         ((low_b.array() - slack) <= high_a.array()).all();
}

// How far along the axis a cylinder's face reaches in each sector, in the frame (R, o) with z along the axis.
struct Reach {
  std::array<double, kBins> low, high;
};

Reach reach_of(const PlacedPart& part, const PlacedFace& face, const Matrix3d& R, const Vector3d& o) {
  Reach reach;
  reach.low.fill(std::numeric_limits<double>::infinity());
  reach.high.fill(-std::numeric_limits<double>::infinity());
  constexpr double whole = 2.0 * std::numbers::pi, step = whole / kBins;
  for (const Eigen::Vector3i& t : face.face->triangles) {
    std::array<double, 3> angle;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int k = 0; k < 3; ++k) {
      const Vector3d x = R.transpose() * (part.vertices[static_cast<std::size_t>(t[k])] - o);
      angle[static_cast<std::size_t>(k)] = std::atan2(x.y(), x.x());
      low = std::min(low, x.z());
      high = std::max(high, x.z());
    }
    double first = 0.0, last = 0.0;  // beside the first corner's
    for (int k = 1; k < 3; ++k) {
      const double d = std::remainder(angle[static_cast<std::size_t>(k)] - angle[0], whole);
      first = std::min(first, d);
      last = std::max(last, d);
    }
    // Bins whose middle the triangle covers.
    const int begin = static_cast<int>(std::ceil((angle[0] + first) / step - 0.5 - 1e-9)),
              end = static_cast<int>(std::floor((angle[0] + last) / step - 0.5 + 1e-9));
    for (int b = begin; b <= end; ++b) {
      const auto at = static_cast<std::size_t>(((b % kBins) + kBins) % kBins);
      reach.low[at] = std::min(reach.low[at], low);
      reach.high[at] = std::max(reach.high[at], high);
    }
  }
  return reach;
}

bool cylinders_touch(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                     double clearance, FacePair& pair) {
  if (fa.hole == fb.hole || fa.axis.cross(fb.axis).norm() > kAngle) return false;
  const PlacedFace &shaft = fa.hole ? fb : fa, &bore = fa.hole ? fa : fb;
  const double gap = bore.radius - shaft.radius;
  if (std::abs(gap) > clearance) return false;
  const Vector3d between = bore.point - shaft.point;
  if ((between - shaft.axis * shaft.axis.dot(between)).norm() > clearance) return false;
  const Matrix3d R = mbs::frame_along(shaft.axis);
  const Reach ra = reach_of(a, fa, R, shaft.point), rb = reach_of(b, fb, R, shaft.point);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int k = 0; k < kBins; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double z0 = std::max(ra.low[i], rb.low[i]), z1 = std::min(ra.high[i], rb.high[i]);
    // An edge that only meets the other's end is no seat.
    if (!(z1 - z0 > 1e-3 * shaft.radius)) continue;
    low = std::min(low, z0);
    high = std::max(high, z1);
    const double angle = (k + 0.5) * 2.0 * std::numbers::pi / kBins;
    const Vector3d radial = R * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const Vector3d n = fa.hole ? Vector3d(-radial) : radial;  // out of A
    for (const double z : {z0, z1})
      pair.contacts.push_back({shaft.point + shaft.radius * radial + z * shaft.axis, n});
  }
  if (pair.contacts.empty()) return false;
  pair.kind = FaceKind::cylinder;
  pair.shaft_in_a = !fa.hole;
  pair.radius = shaft.radius;
  pair.gap = gap;
  pair.extent = high - low;
  pair.axis = shaft.axis;
  pair.point = shaft.point + 0.5 * (low + high) * shaft.axis;
  return true;
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

// Ericson, Real-Time Collision Detection, section 5.1.5.
double distance(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return ap.norm();
  const Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return bp.norm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return (ap - ab * (d1 / (d1 - d3))).norm();
  const Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return cp.norm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return (ap - ac * (d2 / (d2 - d6))).norm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return (p - (b + w * (c - b))).norm();
  }
  const double whole = va + vb + vc;
  if (!(whole > 0.0)) return ap.norm();  // a triangle without area
  return (ap - ab * (vb / whole) - ac * (vc / whole)).norm();
}

// Corners of `a` against triangles of `b`.
double corners_to_triangles(const PlacedPart& a, const PlacedPart& b, double within) {
  double least = within;
  std::vector<const Vector3d*> corners;
  for (const Vector3d& v : a.vertices)
    if (boxes_meet(v, v, b.low, b.high, within)) corners.push_back(&v);
  if (corners.empty()) return least;
  for (const PlacedFace& face : b.faces) {
    if (!boxes_meet(face.low, face.high, a.low, a.high, within)) continue;
    for (const Eigen::Vector3i& t : face.face->triangles) {
      const Vector3d &x = b.vertices[static_cast<std::size_t>(t[0])],
                     &y = b.vertices[static_cast<std::size_t>(t[1])],
                     &z = b.vertices[static_cast<std::size_t>(t[2])];
      const Vector3d low = x.cwiseMin(y).cwiseMin(z), high = x.cwiseMax(y).cwiseMax(z);
      if (!boxes_meet(low, high, a.low, a.high, within)) continue;
      for (const Vector3d* v : corners)
        if (boxes_meet(*v, *v, low, high, least)) least = std::min(least, distance(*v, x, y, z));
    }
  }
  return least;
}

}  // namespace

double nearest(const PlacedPart& a, const PlacedPart& b, double within) {
  if (!boxes_meet(a.low, a.high, b.low, b.high, within)) return within;
  return std::min(corners_to_triangles(a, b, within), corners_to_triangles(b, a, within));
}

PlacedPart place(const Part& part, const Pose& X) {
  PlacedPart placed;
  placed.low.setConstant(std::numeric_limits<double>::infinity());
  placed.high = -placed.low;
  for (const Vector3d& v : part.surface.vertices) placed.vertices.push_back(X * v);
  for (const Face& face : part.faces) {
    const mesh::Face& s = face.shape;
    PlacedFace f{.kind = s.kind, .number = static_cast<int>(s.number), .hole = s.hole, .radius = s.radius};
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
