// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

#include "mbs/base/math/spatial.hpp"
#include "mbs/kinematics/kinematics.hpp"

namespace flexura::mbs {

/// A line through markers of a body that deforms with it: what travels along has its place s there [m], the sum of the
/// chords between the markers of the undeformed body from the first one on, so that s names a particle of the line
/// however the body deforms.
///
/// Whatever the markers carry, positions X_j or directions fixed in them, is continued between them by
///
///     f(s) = sum_j b_j(s) f_j,
///
/// quintic Hermite pieces with the first and second derivatives of the polynomial of degree four through the five
/// nearest markers at each end: twice continuously differentiable, so that the force on a mass which passes a marker
/// does not jump; exact for polynomials of degree four; and at most six markers have a part in it.  The line has the
/// markers' positions alone, not their rotations: right for surfaces, whose nodes have none, and for beams with shear,
/// whose sections do not stay normal to it.  Beyond its ends it goes on straight.
class BodyPath {
 public:
  static constexpr int kActive = 6;
  /// Of the markers first, first + 1, ..., first + n - 1: rows are the orders of the derivative by s.
  struct Weights {
    int first = 0, n = 0;
    Eigen::Matrix<double, 4, kActive> b = Eigen::Matrix<double, 4, kActive>::Zero();
  };

  /// `undeformed` are the markers' poses in axes of the part that they sit on.  Throws std::invalid_argument: fewer than
  /// two markers, two neighbours in one place.
  BodyPath(std::vector<int> markers, const std::vector<Pose>& undeformed);

  int size() const { return static_cast<int>(markers_.size()); }
  int marker(int j) const { return markers_[static_cast<std::size_t>(j)]; }
  const std::vector<int>& markers() const { return markers_; }
  double length() const { return places_.back(); }
  /// Of marker j.
  double place(int j) const { return places_[static_cast<std::size_t>(j)]; }
  /// False beyond the ends by more than round-off.
  bool holds(double s) const;
  Weights weights(double s) const;
  /// Two directions that stand normal on the undeformed line, in the axes of marker j: to its left and up, as
  /// SpaceCurve::Frame has them.
  const Vector3d& side(int j) const { return normals_[static_cast<std::size_t>(j)].first; }
  const Vector3d& up(int j) const { return normals_[static_cast<std::size_t>(j)].second; }
  /// The place whose tangent stands normal on the line from it to the point (in W), found from `from` (NaN: anywhere).
  double foot(const Kinematics& kin, const Vector3d& point_W, double from) const;

 private:
  using Piece = Eigen::Matrix<double, 6, kActive>;  ///< coefficients of u^0 ... u^5, u from 0 to 1
  bool refine(const Kinematics& kin, const Vector3d& point_W, double& s) const;

  std::vector<int> markers_;
  std::vector<double> places_;
  std::vector<std::pair<Vector3d, Vector3d>> normals_;
  std::vector<Piece> pieces_;
  std::vector<int> first_, active_;  ///< of each piece
};

}  // namespace flexura::mbs
