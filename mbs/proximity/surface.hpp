// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "mbs/base/math/spatial.hpp"

/// Distances and overlaps of two triangulated surfaces, by bounding volumes: FCL (J. Pan, S. Chitta, D. Manocha, ICRA 2012).
///
/// All lengths in [m]. X_WA is the pose in which a surface stands.
namespace flexura::proximity {

using Eigen::Vector3d;
using mbs::Pose;

class Surface {
 public:
  /// Corners that lie on one another become one.  At least one triangle.
  Surface(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles);
  ~Surface();
  Surface(Surface&&) noexcept;
  Surface& operator=(Surface&&) noexcept;

  /// The vertices as given to the constructor, elsewhere.
  void move_vertices(const Eigen::Matrix3Xd& vertices);

  /// Every edge joins two triangles that look the same way: there is an inside.
  bool is_closed() const;
  /// How far flat facets may stand off the round surface that they stand for: the largest sagitta, width times angle over 8,
  /// over edges at which the surface turns by less than 45 degrees.
  double facet_error() const;
  const Eigen::AlignedBox3d& box() const;  ///< in its own frame

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

struct Gap {
  double distance = 0.0;  ///< 0 where the surfaces cross
  Vector3d p_W_A = Vector3d::Zero(),
           p_W_B = Vector3d::Zero();  ///< nearest points; of no meaning where they cross
};
Gap gap_between(const Surface& a, const Pose& X_WA, const Surface& b, const Pose& X_WB);

struct Overlap {
  /// How deep a point of either surface lies in the other, the deepest to 2 % as far as a thousand cuts of facets find it.
  /// Nothing where a surface is not closed.
  std::optional<double> depth;
  Vector3d p_W = Vector3d::Zero();  ///< the deepest point, or one where they cross
};
/// Nothing where neither crosses the other nor lies within it.  A depth up to `beyond` [m] is told less exactly, and sooner.
std::optional<Overlap> overlap_of(const Surface& a, const Pose& X_WA, const Surface& b, const Pose& X_WB,
                                  double beyond = 0.0);

}  // namespace flexura::proximity
