// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/round_contacts.hpp"

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

constexpr int kBins = 72;  // of the circle, 5 degrees each

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

// The radius of a cone at a place along an axis, by the corners of its triangles, which lie on it: radius + slope z.
struct Taper {
  double radius = 0.0, slope = 0.0;
  double at(double z) const { return radius + slope * z; }
};

Taper taper_of(const PlacedPart& part, const PlacedFace& face, const Vector3d& axis, const Vector3d& o) {
  double n = 0.0, z1 = 0.0, z2 = 0.0, r1 = 0.0, rz = 0.0;
  for (const Eigen::Vector3i& t : face.face->triangles)
    for (int k = 0; k < 3; ++k) {
      const Vector3d x = part.vertices[static_cast<std::size_t>(t[k])] - o;
      const double z = axis.dot(x), r = (x - z * axis).norm();
      n += 1.0;
      z1 += z;
      z2 += z * z;
      r1 += r;
      rz += r * z;
    }
  const double d = n * z2 - z1 * z1;
  const double slope = d > 0.0 ? (n * rz - z1 * r1) / d : 0.0;
  return {n > 0.0 ? (r1 - slope * z1) / n : 0.0, slope};
}

}  // namespace

bool cylinders_touch(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                     double clearance, FacePair& pair) {
  if (fa.hole == fb.hole || fa.axis.cross(fb.axis).norm() > kSameDirection) return false;
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

bool cones_touch(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                 double clearance, FacePair& pair) {
  if (fa.hole == fb.hole || fa.axis.cross(fb.axis).norm() > kSameDirection) return false;
  const PlacedFace &shaft = fa.hole ? fb : fa, &bore = fa.hole ? fa : fb;
  const PlacedPart &shaft_part = fa.hole ? b : a, &bore_part = fa.hole ? a : b;
  const Vector3d between = bore.point - shaft.point;
  if ((between - shaft.axis * shaft.axis.dot(between)).norm() > clearance) return false;
  const Taper cone = taper_of(shaft_part, shaft, shaft.axis, shaft.point),
              seat = taper_of(bore_part, bore, shaft.axis, shaft.point);
  if (std::abs(std::atan(cone.slope) - std::atan(seat.slope)) > kSameDirection) return false;
  const double cosine = 1.0 / std::hypot(1.0, cone.slope);
  const Matrix3d R = mbs::frame_along(shaft.axis);
  const Reach rs = reach_of(shaft_part, shaft, R, shaft.point),
              rb = reach_of(bore_part, bore, R, shaft.point);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int k = 0; k < kBins; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double z0 = std::max(rs.low[i], rb.low[i]), z1 = std::min(rs.high[i], rb.high[i]);
    if (!(z1 - z0 > 1e-3 * shaft.radius)) continue;
    const double gap = cosine * (seat.at(0.5 * (z0 + z1)) - cone.at(0.5 * (z0 + z1)));
    if (std::abs(gap) > clearance) continue;
    pair.gap = gap;
    low = std::min(low, z0);
    high = std::max(high, z1);
    const double angle = (k + 0.5) * 2.0 * std::numbers::pi / kBins;
    const Vector3d radial = R * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const Vector3d out = cosine * (radial - cone.slope * shaft.axis), n = fa.hole ? Vector3d(-out) : out;
    for (const double z : {z0, z1})
      pair.contacts.push_back({shaft.point + cone.at(z) * radial + z * shaft.axis, n});
  }
  if (pair.contacts.empty()) return false;
  pair.kind = FaceKind::cone;
  pair.shaft_in_a = !fa.hole;
  pair.radius = cone.at(0.5 * (low + high));
  pair.extent = high - low;
  pair.axis = shaft.axis;
  pair.point = shaft.point + 0.5 * (low + high) * shaft.axis;
  return true;
}

}  // namespace flexura::import::cad
