// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/kinematics/surface_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

namespace flexura::mbs {
namespace {

using Triangle = std::array<Vector3d, 3>;
using Gap = SurfaceMesh::Gap;

// Ericson, Real-Time Collision Detection, section 5.1.5.
Vector3d nearest_on(const Triangle& t, const Vector3d& p) {
  const Vector3d ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return t[0];
  const Vector3d bp = p - t[1];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return t[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return t[0] + d1 / (d1 - d3) * ab;
  const Vector3d cp = p - t[2];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return t[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return t[0] + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return t[1] + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1]);
  const double whole = va + vb + vc;
  if (!(whole > 0.0)) return t[0];  // a triangle without area
  return t[0] + vb / whole * ab + vc / whole * ac;
}

// Section 5.1.9: the nearest points of two segments.
std::pair<Vector3d, Vector3d> nearest_of(const Vector3d& p1, const Vector3d& q1, const Vector3d& p2,
                                         const Vector3d& q2) {
  const Vector3d d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r);
  double s = 0.0, t = 0.0;
  if (a > 0.0 && e > 0.0) {
    const double c = d1.dot(r), b = d1.dot(d2), denominator = a * e - b * b;
    if (denominator > 1e-14 * a * e) s = std::clamp((b * f - c * e) / denominator, 0.0, 1.0);
    t = (b * s + f) / e;
    if (t < 0.0 || t > 1.0) {
      t = std::clamp(t, 0.0, 1.0);
      s = std::clamp((b * t - c) / a, 0.0, 1.0);
    }
  } else if (e > 0.0) {
    t = std::clamp(f / e, 0.0, 1.0);
  } else if (a > 0.0) {
    s = std::clamp(-d1.dot(r) / a, 0.0, 1.0);
  }
  return {p1 + s * d1, p2 + t * d2};
}

// Where the segment goes through the triangle.
bool pierces(const Vector3d& p, const Vector3d& q, const Triangle& t, Vector3d& at) {
  const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double from = n.dot(p - t[0]), to = n.dot(q - t[0]);
  if (from * to > 0.0 || from == to) return false;
  at = p + from / (from - to) * (q - p);
  for (std::size_t k = 0; k < 3; ++k)
    if ((t[(k + 1) % 3] - t[k]).cross(at - t[k]).dot(n) < 0.0) return false;
  return true;
}

void look(const Triangle& a, const Triangle& b, Gap& best) {
  const auto take = [&](const Vector3d& p, const Vector3d& q) {
    if (const double d = (p - q).norm(); d < best.distance) best = {d, p, q};
  };
  Vector3d at;
  for (std::size_t k = 0; k < 3; ++k) {
    if (pierces(a[k], a[(k + 1) % 3], b, at) || pierces(b[k], b[(k + 1) % 3], a, at)) {
      best = {0.0, at, at};
      return;
    }
    take(a[k], nearest_on(b, a[k]));
    take(nearest_on(a, b[k]), b[k]);
    for (std::size_t l = 0; l < 3; ++l) {
      const auto [p, q] = nearest_of(a[k], a[(k + 1) % 3], b[l], b[(l + 1) % 3]);
      take(p, q);
    }
  }
}

}  // namespace

struct SurfaceMesh::Search {
  const SurfaceMesh &a, &b;
  const double *s_a, *s_b;
  const Pose& X_AB;
  Gap best;

  double bound(int group_a, int group_b) const {
    const Ball at = a.ball(group_a, s_a), to = b.ball(group_b, s_b);
    return (at.c - X_AB.p - X_AB.R * to.c).norm() - at.r - to.r;
  }
  void descend(int group_a, int group_b) {
    const Group &p = a.groups_[static_cast<std::size_t>(group_a)],
                &q = b.groups_[static_cast<std::size_t>(group_b)];
    if (p.left < 0 && q.left < 0) {
      leaves(p, q);
      return;
    }
    const bool split_a = q.left < 0 || (p.left >= 0 && p.r >= q.r);
    std::array<std::pair<int, int>, 2> next;
    if (split_a)
      next = {{{p.left, group_b}, {p.right, group_b}}};
    else
      next = {{{group_a, q.left}, {group_a, q.right}}};
    std::array<double, 2> least = {bound(next[0].first, next[0].second),
                                   bound(next[1].first, next[1].second)};
    if (least[1] < least[0]) {
      std::swap(next[0], next[1]);
      std::swap(least[0], least[1]);
    }
    for (std::size_t k = 0; k < 2; ++k)
      if (least[k] < best.distance) descend(next[k].first, next[k].second);
  }
  void leaves(const Group& p, const Group& q) {
    const auto corners = [](const SurfaceMesh& mesh, const double* s, int t) {
      const Eigen::Vector3i& f = mesh.triangles_[static_cast<std::size_t>(t)];
      return Triangle{mesh.vertex(f[0], s), mesh.vertex(f[1], s), mesh.vertex(f[2], s)};
    };
    for (int j = q.begin; j < q.end; ++j) {
      Triangle other = corners(b, s_b, j);
      for (Vector3d& x : other) x = X_AB.p + X_AB.R * x;
      for (int i = p.begin; i < p.end && best.distance > 0.0; ++i) look(corners(a, s_a, i), other, best);
    }
  }
};

SurfaceMesh::SurfaceMesh(const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xi& triangles) : x_(x) {
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) triangles_.push_back(triangles.col(t));
  if (triangles_.empty()) throw std::invalid_argument("a surface needs a triangle; give the body one");
  build(0, static_cast<int>(triangles_.size()));
}

int SurfaceMesh::build(int begin, int end) {
  const auto middle = [&](const Eigen::Vector3i& t) {
    return Vector3d((x_.col(t[0]) + x_.col(t[1]) + x_.col(t[2])) / 3.0);
  };
  Group group{.begin = begin, .end = end, .c = Vector3d::Zero()};
  Eigen::AlignedBox3d box;
  for (int t = begin; t < end; ++t)
    for (int k = 0; k < 3; ++k) box.extend(Vector3d(x_.col(triangles_[static_cast<std::size_t>(t)][k])));
  group.c = box.center();
  for (int t = begin; t < end; ++t)
    for (int k = 0; k < 3; ++k) {
      const Vector3d corner = x_.col(triangles_[static_cast<std::size_t>(t)][k]);
      group.r = std::max(group.r, (corner - group.c).norm());
      group.longest =
          std::max(group.longest, (corner - middle(triangles_[static_cast<std::size_t>(t)])).norm());
    }
  const int own = static_cast<int>(groups_.size());
  groups_.push_back(group);
  if (end - begin > kLeaf) {
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const int half = (begin + end) / 2;
    std::nth_element(triangles_.begin() + begin, triangles_.begin() + half, triangles_.begin() + end,
                     [&](const auto& s, const auto& t) { return middle(s)[axis] < middle(t)[axis]; });
    const int left = build(begin, half), right = build(half, end);
    groups_[static_cast<std::size_t>(own)].left = left;
    groups_[static_cast<std::size_t>(own)].right = right;
  }
  return own;
}

void SurfaceMesh::set_shapes(const Eigen::MatrixXd& Phi) {
  if (Phi.rows() != 3 * x_.cols())
    throw std::invalid_argument("shapes of a surface need three rows for each of its vertices");
  Phi_ = Phi;
  const auto n = static_cast<Eigen::Index>(groups_.size());
  mean_ = Shapes::Zero(3 * n, Phi.cols());
  spread_ = Shapes::Zero(n, Phi.cols());
  for (Eigen::Index g = 0; g < n; ++g) {
    std::set<int> vertices;
    const Group& group = groups_[static_cast<std::size_t>(g)];
    for (int t = group.begin; t < group.end; ++t)
      for (int k = 0; k < 3; ++k) vertices.insert(triangles_[static_cast<std::size_t>(t)][k]);
    for (const int j : vertices)
      mean_.middleRows<3>(3 * g) += Phi_.middleRows<3>(3 * j) / static_cast<double>(vertices.size());
    for (const int j : vertices)
      spread_.row(g) =
          spread_.row(g).cwiseMax((Phi_.middleRows<3>(3 * j) - mean_.middleRows<3>(3 * g)).colwise().norm());
  }
}

SurfaceMesh::Ball SurfaceMesh::ball(int group, const double* s) const {
  const Group& g = groups_[static_cast<std::size_t>(group)];
  if (!s || m() == 0) return {g.c, g.r};
  const Eigen::Map<const Eigen::VectorXd> s_m(s, m());
  return {g.c + mean_.middleRows<3>(3 * group) * s_m, g.r + spread_.row(group).dot(s_m.cwiseAbs())};
}

Vector3d SurfaceMesh::vertex(int j, const double* s) const {
  Vector3d x = x_.col(j);
  if (s && m() > 0) x += Phi_.middleRows<3>(3 * j) * Eigen::Map<const Eigen::VectorXd>(s, m());
  return x;
}

Vector3d SurfaceMesh::velocity(int j, const double* s_dot) const {
  if (!s_dot || m() == 0) return Vector3d::Zero();
  return shapes(j) * Eigen::Map<const Eigen::VectorXd>(s_dot, m());
}

SurfaceMesh::Gap SurfaceMesh::between(const SurfaceMesh& a, const double* s_a, const SurfaceMesh& b,
                                      const double* s_b, const Pose& X_AB) {
  Search search{a, b, s_a, s_b, X_AB, {.distance = std::numeric_limits<double>::infinity()}};
  search.descend(0, 0);
  return search.best;
}

}  // namespace flexura::mbs
