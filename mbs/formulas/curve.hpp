// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mbs/base/math/interval.hpp"

/// Curves through tabulated points (x_i, y_i), x rising.
///
///     linear   straight between the points
///     cubic    the natural spline, twice differentiable: what drives want (C. de Boor, A Practical Guide
///              to Splines)
///     akima    cubic pieces whose slopes follow the neighbouring points without overshoot, once
///              differentiable (H. Akima, J. ACM 17 (1970) 589-602)
///
/// Outside the points a curve holds its end value, goes on with its end slope, or repeats with the period
/// x_n - x_0.
namespace flexura::mbs {

class Curve {
 public:
  enum class Interpolation { linear, cubic, akima };
  enum class Outside { hold, extend, repeat };

  struct Value {
    double value, first, second, third;  ///< y and its derivatives by x
  };

  /// Throws std::invalid_argument: fewer than two points, x not rising, numbers not finite, a repeated curve
  /// whose ends differ.
  Curve(std::vector<double> x, std::vector<double> y, Interpolation interpolation, Outside outside);

  Value at(double x) const;
  double operator()(double x) const { return at(x).value; }
  /// The integral from 0 to x: the energy of a spring with this force.
  double integral(double x) const { return antiderivative(x) - at_zero_; }

  struct Bounds {
    Interval value, first, second;
  };
  /// What the curve and its derivatives are between two x.
  Bounds over(const Interval& x) const;
  /// The number of kinks up to x: points where the slope (or, of an Akima curve, the second derivative)
  /// jumps.  Bends that a dense table of a smooth curve has, of less than 1e-4 of its range from one point to
  /// the next, are none.
  double kinks_until(double x) const;
  /// Between which x there are as many, itself between their ends.
  Interval between_kinks(double x) const;
  int kinks() const { return kinks_.back(); }  ///< at all points

 private:
  /// y = c0 + c1 u + c2 u^2 + c3 u^3, u = x - x_i.
  struct Piece {
    double c0, c1, c2, c3, sum;  ///< sum: the integral from x_0 to x_i
  };
  std::size_t piece_of(double x) const;
  double periods(double x) const;
  void find_kinks();
  Bounds over_pieces(double a, double b) const;
  double antiderivative(double x) const;

  std::vector<double> x_;
  std::vector<Piece> pieces_;  ///< n - 1
  Outside outside_;
  Piece before_, after_;  ///< straight lines beyond the ends
  double whole_ = 0.0, at_zero_ = 0.0;
  std::vector<int> kinks_;  ///< at points up to each one
  Bounds bounds_;           ///< of all pieces between the ends
};

/// Tables of a mechanism file by their names, for formulas and elements.
using Curves = std::map<std::string, std::shared_ptr<const Curve>>;

}  // namespace flexura::mbs
