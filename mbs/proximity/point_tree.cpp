// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/proximity/point_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

namespace flexura::proximity {
namespace {

constexpr int kLeaf = 4;  // triangles

// The point of the triangle abc nearest to p (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5); feature: 0 to 2 a
// corner, 3 to 5 the side opposite of it, 6 the inside.
Vector3d nearest_of_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c,
                             int& feature) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return feature = 0, a;
  const Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return feature = 1, b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return feature = 5, Vector3d(a + d1 / (d1 - d3) * ab);
  const Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return feature = 2, c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return feature = 4, Vector3d(a + d2 / (d2 - d6) * ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return feature = 3, Vector3d(b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b));
  const double sum = va + vb + vc;
  return feature = 6, Vector3d(a + vb / sum * ab + vc / sum * ac);
}

}  // namespace

PointTree::PointTree(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles)
    : vertices_(vertices), triangles_(triangles), order_(static_cast<std::size_t>(triangles.cols())) {
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(order_.size() + 1);
  build(0, static_cast<int>(order_.size()));
  find_edges();
  refit();
}

int PointTree::build(int begin, int end) {
  const auto index = static_cast<int>(nodes_.size());
  nodes_.push_back({.box = {}, .begin = begin, .end = end});
  if (end - begin <= kLeaf) return index;
  Eigen::AlignedBox3d middles;
  const auto middle = [&](int t) {
    return Vector3d((vertices_.col(triangles_(0, t)) + vertices_.col(triangles_(1, t)) +
                     vertices_.col(triangles_(2, t))) /
                    3.0);
  };
  for (int i = begin; i < end; ++i) middles.extend(middle(order_[static_cast<std::size_t>(i)]));
  Eigen::Index axis = 0;
  middles.sizes().maxCoeff(&axis);
  const int half = (begin + end) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                   [&](int s, int t) { return middle(s)(axis) < middle(t)(axis); });
  const int left = build(begin, half), right = build(half, end);
  nodes_[static_cast<std::size_t>(index)].left = left;
  nodes_[static_cast<std::size_t>(index)].right = right;
  return index;
}

void PointTree::find_edges() {
  std::map<std::pair<int, int>, int> known;
  edge_of_.resize(3, triangles_.cols());
  for (Eigen::Index t = 0; t < triangles_.cols(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int a = triangles_((k + 1) % 3, t), b = triangles_((k + 2) % 3, t);
      edge_of_(k, t) = known.try_emplace(std::minmax(a, b), static_cast<int>(known.size())).first->second;
    }
  n_edges_ = static_cast<int>(known.size());
}

void PointTree::refit() {
  // Children stand behind their parents.
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    node.box.setEmpty();
    if (node.left >= 0) {
      node.box.extend(nodes_[static_cast<std::size_t>(node.left)].box);
      node.box.extend(nodes_[static_cast<std::size_t>(node.right)].box);
      continue;
    }
    for (int k = node.begin; k < node.end; ++k)
      for (int corner = 0; corner < 3; ++corner)
        node.box.extend(Vector3d(vertices_.col(triangles_(corner, order_[static_cast<std::size_t>(k)]))));
  }
  find_normals();
}

void PointTree::find_normals() {
  face_normals_.resize(3, triangles_.cols());
  edge_normals_ = Eigen::Matrix3Xd::Zero(3, n_edges_);
  vertex_normals_ = Eigen::Matrix3Xd::Zero(3, vertices_.cols());
  for (Eigen::Index t = 0; t < triangles_.cols(); ++t) {
    std::array<Vector3d, 3> x;
    for (int k = 0; k < 3; ++k) x[static_cast<std::size_t>(k)] = vertices_.col(triangles_(k, t));
    const Vector3d n = (x[1] - x[0]).cross(x[2] - x[0]).stableNormalized();
    face_normals_.col(t) = n;
    for (std::size_t k = 0; k < 3; ++k) {
      edge_normals_.col(edge_of_(static_cast<Eigen::Index>(k), t)) += n;
      const Vector3d u = (x[(k + 1) % 3] - x[k]).stableNormalized(),
                     v = (x[(k + 2) % 3] - x[k]).stableNormalized();
      vertex_normals_.col(triangles_(static_cast<Eigen::Index>(k), t)) +=
          std::acos(std::clamp(u.dot(v), -1.0, 1.0)) * n;
    }
  }
}

void PointTree::look(int index, const Vector3d& p, double& square, int& triangle, int& feature,
                     Vector3d& at) const {
  const Node& node = nodes_[static_cast<std::size_t>(index)];
  if (node.left < 0) {
    for (int k = node.begin; k < node.end; ++k) {
      const int t = order_[static_cast<std::size_t>(k)];
      int part = 6;
      const Vector3d x =
          nearest_of_triangle(p, vertices_.col(triangles_(0, t)), vertices_.col(triangles_(1, t)),
                              vertices_.col(triangles_(2, t)), part);
      if (const double d = (p - x).squaredNorm(); d < square) {
        square = d;
        triangle = t;
        feature = part;
        at = x;
      }
    }
    return;
  }
  std::array<std::pair<double, int>, 2> next = {
      std::pair{nodes_[static_cast<std::size_t>(node.left)].box.squaredExteriorDistance(p), node.left},
      std::pair{nodes_[static_cast<std::size_t>(node.right)].box.squaredExteriorDistance(p), node.right}};
  if (next[1].first < next[0].first) std::swap(next[0], next[1]);
  for (const auto& [bound, child] : next)
    if (bound < square) look(child, p, square, triangle, feature, at);
}

PointTree::Nearest PointTree::nearest(const Vector3d& p) const {
  double square = std::numeric_limits<double>::infinity();
  int triangle = -1, feature = 6;
  Nearest out;
  look(0, p, square, triangle, feature, out.at);
  const Vector3d n = feature < 3   ? Vector3d(vertex_normals_.col(triangles_(feature, triangle)))
                     : feature < 6 ? Vector3d(edge_normals_.col(edge_of_(feature - 3, triangle)))
                                   : Vector3d(face_normals_.col(triangle));
  out.distance = std::copysign(std::sqrt(square), n.dot(p - out.at));
  return out;
}

}  // namespace flexura::proximity
