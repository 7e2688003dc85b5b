// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/proximity/surface.hpp"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <queue>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mbs/proximity/point_tree.hpp"

namespace flexura::proximity {

using Model = fcl::BVHModel<fcl::OBBRSSd>;

struct Surface::Impl {
  Eigen::Matrix3Xd vertices;  // welded
  Eigen::Matrix3Xi triangles;
  std::vector<int> welded_to;  // of every vertex given
  std::unique_ptr<PointTree> tree;
  std::shared_ptr<Model> model;
  bool closed = false;
  double facet_error = 0.0;

  void weld(const Eigen::Matrix3Xd& given, const Eigen::Matrix3Xi& faces);
  void look_at_edges();
  void make_model();
};

namespace {

constexpr int kMostCuts = 1000;  // of facets, in the search for the deepest point

fcl::Transform3d transform(const Pose& X) {
  fcl::Transform3d T = fcl::Transform3d::Identity();
  T.linear() = X.R;
  T.translation() = X.p;
  return T;
}

// A part of a facet, and how deep any point of it may lie at the most.
struct Piece {
  std::array<Vector3d, 3> x;
  double most;
  bool operator<(const Piece& other) const { return most < other.most; }
};

// The deepest point of the facets of `a` within `b`, whose inside is known, in the frame of b; depth and p are those found so far.
// The depth changes by no more than one goes: of a piece with the middle m it is at most that of m and the distance to its
// farthest corner.  The most promising piece is cut, until none could be deeper by 2 %, or than `beyond`, which is of no interest.
void find_deepest(const Surface::Impl& a, const Pose& X_BA, const Surface::Impl& b, double beyond,
                  double& depth, Vector3d& p) {
  std::priority_queue<Piece> pieces;
  const auto look = [&](const Vector3d& x) {
    const double d = -b.tree->nearest(x).distance;
    if (d > depth) {
      depth = d;
      p = x;
    }
    return d;
  };
  const auto add = [&](const std::array<Vector3d, 3>& x) {
    const Vector3d m = (x[0] + x[1] + x[2]) / 3.0;
    const double reach = std::max({(x[0] - m).norm(), (x[1] - m).norm(), (x[2] - m).norm()});
    if (const double most = look(m) + reach; most > std::max(depth, beyond)) pieces.push({x, most});
  };
  const auto enter = [&](const Eigen::AlignedBox3d& box) {
    // The middle of a box is no point of the surface: it bounds what is within alone.
    const double middle = -b.tree->nearest(X_BA * Vector3d(box.center())).distance;
    return middle + 0.5 * box.diagonal().norm() > std::max(depth, beyond);
  };
  a.tree->descend(enter, [&](int t) {
    std::array<Vector3d, 3> x;
    for (Eigen::Index k = 0; k < 3; ++k) {
      x[static_cast<std::size_t>(k)] = X_BA * Vector3d(a.vertices.col(a.triangles(k, t)));
      look(x[static_cast<std::size_t>(k)]);
    }
    add(x);
  });
  const auto is_open = [&] { return !pieces.empty() && pieces.top().most > std::max(1.02 * depth, beyond); };
  for (int cut = 0; cut < kMostCuts && is_open(); ++cut) {
    std::array<Vector3d, 3> x = pieces.top().x;
    pieces.pop();
    // In two across the longest side: facets of round faces are long and narrow.
    std::size_t longest = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if ((x[(k + 1) % 3] - x[k]).norm() > (x[(longest + 1) % 3] - x[longest]).norm()) longest = k;
    const Vector3d middle = 0.5 * (x[longest] + x[(longest + 1) % 3]), last = x[(longest + 2) % 3];
    add({x[longest], middle, last});
    add({middle, x[(longest + 1) % 3], last});
  }
}

}  // namespace

void Surface::Impl::weld(const Eigen::Matrix3Xd& given, const Eigen::Matrix3Xi& faces) {
  const double size =
      given.cols() > 0 ? (given.rowwise().maxCoeff() - given.rowwise().minCoeff()).norm() : 0.0;
  const double grain = std::max(1e-7 * size, 1e-15);
  std::map<std::array<long long, 3>, int> known;
  std::vector<int> first;
  for (Eigen::Index v = 0; v < given.cols(); ++v) {
    std::array<long long, 3> key{};
    for (Eigen::Index k = 0; k < 3; ++k) key[static_cast<std::size_t>(k)] = std::llround(given(k, v) / grain);
    const auto [at, fresh] = known.try_emplace(key, static_cast<int>(first.size()));
    if (fresh) first.push_back(static_cast<int>(v));
    welded_to.push_back(at->second);
  }
  vertices.resize(3, static_cast<Eigen::Index>(first.size()));
  for (std::size_t i = 0; i < first.size(); ++i)
    vertices.col(static_cast<Eigen::Index>(i)) = given.col(first[i]);
  std::vector<Eigen::Vector3i> kept;
  for (Eigen::Index t = 0; t < faces.cols(); ++t) {
    const Eigen::Vector3i f(welded_to[static_cast<std::size_t>(faces(0, t))],
                            welded_to[static_cast<std::size_t>(faces(1, t))],
                            welded_to[static_cast<std::size_t>(faces(2, t))]);
    if (f.x() != f.y() && f.y() != f.z() && f.z() != f.x()) kept.push_back(f);
  }
  if (kept.empty())
    throw std::invalid_argument(
        "a surface has no triangle that is more than a line; give the body a mesh with an area");
  triangles.resize(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t t = 0; t < kept.size(); ++t) triangles.col(static_cast<Eigen::Index>(t)) = kept[t];
}

void Surface::Impl::look_at_edges() {
  struct Side {
    Eigen::Index triangle;
    bool forwards;
  };
  std::map<std::pair<int, int>, std::vector<Side>> sides;
  for (Eigen::Index t = 0; t < triangles.cols(); ++t)
    for (Eigen::Index k = 0; k < 3; ++k) {
      const int a = triangles(k, t), b = triangles((k + 1) % 3, t);
      sides[std::minmax(a, b)].push_back({t, a < b});
    }
  const auto cross = [&](Eigen::Index t) {
    const Vector3d a = vertices.col(triangles(0, t)), b = vertices.col(triangles(1, t)),
                   c = vertices.col(triangles(2, t));
    return Vector3d((b - a).cross(c - a));
  };
  closed = true;
  for (const auto& [ends, two] : sides) {
    if (two.size() != 2 || two[0].forwards == two[1].forwards) {
      closed = false;
      continue;
    }
    const Vector3d n = cross(two[0].triangle), m = cross(two[1].triangle);
    const double angle = std::atan2(n.cross(m).norm(), n.dot(m));
    if (!(angle < 0.25 * std::numbers::pi)) continue;
    const double length = (vertices.col(ends.first) - vertices.col(ends.second)).norm();
    // The wider of the two facets, across the edge.
    if (length > 0.0)
      facet_error = std::max(facet_error, std::max(n.norm(), m.norm()) / length * angle / 8.0);
  }
}

void Surface::Impl::make_model() {
  model = std::make_shared<Model>();
  model->beginModel(static_cast<int>(triangles.cols()), static_cast<int>(vertices.cols()));
  std::vector<fcl::Vector3d> points;
  for (Eigen::Index v = 0; v < vertices.cols(); ++v) points.emplace_back(vertices.col(v));
  std::vector<fcl::Triangle> faces;
  for (Eigen::Index t = 0; t < triangles.cols(); ++t)
    faces.emplace_back(static_cast<std::size_t>(triangles(0, t)), static_cast<std::size_t>(triangles(1, t)),
                       static_cast<std::size_t>(triangles(2, t)));
  model->addSubModel(points, faces);
  model->endModel();
}

Surface::Surface(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles)
    : impl_(std::make_unique<Impl>()) {
  impl_->weld(vertices, triangles);
  impl_->look_at_edges();
  impl_->tree = std::make_unique<PointTree>(impl_->vertices, impl_->triangles);
  impl_->make_model();
}
Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;

void Surface::move_vertices(const Eigen::Matrix3Xd& vertices) {
  for (Eigen::Index v = 0; v < vertices.cols(); ++v)
    impl_->vertices.col(impl_->welded_to[static_cast<std::size_t>(v)]) = vertices.col(v);
  impl_->tree->refit();
  std::vector<fcl::Vector3d> points;
  for (Eigen::Index v = 0; v < impl_->vertices.cols(); ++v) points.emplace_back(impl_->vertices.col(v));
  impl_->model->beginReplaceModel();
  impl_->model->replaceSubModel(points);
  impl_->model->endReplaceModel(true, true);
}

bool Surface::is_closed() const {
  return impl_->closed;
}
double Surface::facet_error() const {
  return impl_->facet_error;
}
const Eigen::AlignedBox3d& Surface::box() const {
  return impl_->tree->box();
}

Gap gap_between(const Surface& a, const Pose& X_WA, const Surface& b, const Pose& X_WB) {
  fcl::DistanceRequestd request(true);
  fcl::DistanceResultd result;
  fcl::distance(a.impl().model.get(), transform(X_WA), b.impl().model.get(), transform(X_WB), request,
                result);
  Gap out;
  out.distance = std::max(0.0, result.min_distance);
  out.p_W_A = result.nearest_points[0];
  out.p_W_B = result.nearest_points[1];
  return out;
}

std::optional<Overlap> overlap_of(const Surface& a, const Pose& X_WA, const Surface& b, const Pose& X_WB,
                                  double beyond) {
  const Surface::Impl &A = a.impl(), &B = b.impl();
  const Pose X_BA = X_WB.inverse() * X_WA, X_AB = X_BA.inverse();
  const fcl::CollisionRequestd request(1, true);
  fcl::CollisionResultd result;
  fcl::collide(A.model.get(), transform(X_WA), B.model.get(), transform(X_WB), request, result);
  const bool both_closed = A.closed && B.closed;
  if (result.numContacts() == 0) {
    // Without crossing one lies within the other or none does: any corner tells.
    const bool a_within = B.closed && B.tree->box().contains(X_BA * Vector3d(A.vertices.col(0))) &&
                          B.tree->nearest(X_BA * Vector3d(A.vertices.col(0))).distance < 0.0;
    const bool b_within = A.closed && A.tree->box().contains(X_AB * Vector3d(B.vertices.col(0))) &&
                          A.tree->nearest(X_AB * Vector3d(B.vertices.col(0))).distance < 0.0;
    if (!a_within && !b_within) return std::nullopt;
  }
  Overlap out;
  if (result.numContacts() > 0) out.p_W = result.getContact(0).pos;
  if (!both_closed) return out;
  Vector3d p = Vector3d::Zero();
  double depth = 0.0;
  find_deepest(A, X_BA, B, beyond, depth, p);
  if (depth > 0.0) out.p_W = X_WB * p;
  const double of_a = depth;
  find_deepest(B, X_AB, A, beyond, depth, p);
  if (depth > of_a) out.p_W = X_WA * p;
  out.depth = depth;
  return out;
}

}  // namespace flexura::proximity
