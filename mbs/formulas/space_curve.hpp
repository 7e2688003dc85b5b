// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/base/math/spatial.hpp"
#include "mbs/formulas/curve.hpp"

/// A curve in space through given points: a cubic spline r(s), twice differentiable, whose parameter s [m] is
/// the sum of the chords.  An open curve goes on straight beyond its ends; a closed one repeats, its
/// parameter counting on from round to round.
///
/// The foot of a point P on the curve has the parameter with
///
///     (P - r(s)) . r'(s) = 0,     D = r' . r' - (P - r) . r'' > 0    (a least distance, not a greatest)
namespace flexura::mbs {

class SpaceCurve {
 public:
  /// Throws std::invalid_argument: fewer than two points (three of a closed curve), two equal neighbours.
  SpaceCurve(const std::vector<Vector3d>& points, bool closed);

  struct Point {
    Vector3d r, r_1, r_2, r_3;  ///< r and its derivatives by s
  };
  Point at(double s) const;

  /// Two unit normals to the tangent, and their derivatives by s, from an "up" direction that the curve never
  /// runs along.  n_1 lies to the left of a walker whose head points up, n_2 = t x n_1 is up for a plane
  /// curve.
  struct Frame {
    Vector3d n[2], n_1[2], n_2[2];  ///< normals, first and second derivatives
  };
  Frame frame(const Point& point) const;

  /// The foot nearest to P.
  double nearest(const Vector3d& P) const;
  /// The foot that Newton's method finds from s, or nearest() where it finds none.
  double foot(const Vector3d& P, double s) const;

  double length() const { return length_; }  ///< range of s, of one round
  bool is_closed() const { return closed_; }

 private:
  bool refine(const Vector3d& P, double& s) const;
  void choose_up();

  std::vector<Curve> components_;
  std::vector<double> samples_s_;
  std::vector<Vector3d> samples_;
  Vector3d up_ = Vector3d::UnitZ();
  double length_ = 0.0;
  bool closed_;
};

}  // namespace flexura::mbs
