// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/near.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <utility>

namespace flexura::import::cad {
namespace {

// Two normals look at each other within this angle: facets of the pictures stand for round faces, 12 degrees wide.
constexpr double kFacing = -0.85;
constexpr std::size_t kMostPairs = 5'000'000;  // of triangles of two faces

bool boxes_meet(const Vector3d& low_a, const Vector3d& high_a, const Vector3d& low_b, const Vector3d& high_b,
                double slack) {
  return ((low_a.array() - slack) <= high_b.array()).all() &&
         ((low_b.array() - slack) <= high_a.array()).all();
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

Vector3d normal_of(const PlacedPart& part, const Eigen::Vector3i& t) {
  const Vector3d &x = part.vertices[static_cast<std::size_t>(t[0])],
                 &y = part.vertices[static_cast<std::size_t>(t[1])],
                 &z = part.vertices[static_cast<std::size_t>(t[2])];
  return (y - x).cross(z - x).normalized();
}

// Corners of one face of `a`, each with the normal of a triangle that has it, against triangles of a face of `b`.
void face_to_face(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                  double within, std::vector<Near>& found) {
  std::set<int> seen;
  // Threads have ten thousands of triangles, and what binds does so at more places than one.
  const std::size_t work = fa.face->triangles.size() * fb.face->triangles.size(),
                    every = 1 + work / kMostPairs;
  std::size_t turn = 0;
  for (const Eigen::Vector3i& s : fa.face->triangles) {
    if (turn++ % every != 0) continue;
    for (int k = 0; k < 3; ++k) {
      if (!seen.insert(s[k]).second) continue;
      const Vector3d& p = a.vertices[static_cast<std::size_t>(s[k])];
      if (!boxes_meet(p, p, fb.low, fb.high, within)) continue;
      const Vector3d n = normal_of(a, s);
      for (const Eigen::Vector3i& t : fb.face->triangles) {
        const Vector3d &x = b.vertices[static_cast<std::size_t>(t[0])],
                       &y = b.vertices[static_cast<std::size_t>(t[1])],
                       &z = b.vertices[static_cast<std::size_t>(t[2])];
        if (!boxes_meet(p, p, x.cwiseMin(y).cwiseMin(z), x.cwiseMax(y).cwiseMax(z), within)) continue;
        const Vector3d m = normal_of(b, t);
        if (!(n.dot(m) < kFacing)) continue;
        if (const double d = distance(p, x, y, z); d < within)
          found.push_back({fa.number, fb.number, {p, Vector3d(n - m).normalized()}, d});
      }
    }
  }
}

}  // namespace

double nearest(const PlacedPart& a, const PlacedPart& b, double within) {
  if (!boxes_meet(a.low, a.high, b.low, b.high, within)) return within;
  return std::min(corners_to_triangles(a, b, within), corners_to_triangles(b, a, within));
}

std::vector<Near> unjudged(const PlacedPart& a, const PlacedPart& b, const std::vector<FacePair>& judged,
                           double within) {
  std::vector<Near> found;
  if (!boxes_meet(a.low, a.high, b.low, b.high, within)) return found;
  std::set<std::pair<int, int>> known;
  for (const FacePair& p : judged) known.emplace(p.face_a, p.face_b);
  for (const PlacedFace& fa : a.faces) {
    if (!boxes_meet(fa.low, fa.high, b.low, b.high, within)) continue;
    for (const PlacedFace& fb : b.faces) {
      if (known.contains({fa.number, fb.number}) || !boxes_meet(fa.low, fa.high, fb.low, fb.high, within))
        continue;
      face_to_face(a, fa, b, fb, within, found);
      std::vector<Near> back;
      face_to_face(b, fb, a, fa, within, back);
      for (const Near& n : back)
        found.push_back({fa.number, fb.number, {n.contact.p, -n.contact.n}, n.distance});
    }
  }
  return found;
}

}  // namespace flexura::import::cad
