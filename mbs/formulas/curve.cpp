// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/curve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

namespace flexura::mbs {
namespace {

/// Slopes at the points of the natural cubic spline: the tridiagonal system of its first derivatives.
std::vector<double> spline_slopes(const std::vector<double>& x, const std::vector<double>& y, bool periodic) {
  const std::size_t n = x.size();
  // The system is diagonally dominant by a factor of 2: sweeps of Gauss and Seidel gain a factor of 4 each at
  // least and reach round-off in 60, also where a repeated curve closes the system into a ring.
  std::vector<double> s(n, 0.0);
  const auto h = [&](std::size_t i) { return x[i + 1] - x[i]; };
  const auto chord = [&](std::size_t i) { return (y[i + 1] - y[i]) / h(i); };
  for (int sweep = 0; sweep < 60; ++sweep) {
    if (periodic) {
      const double a = 1.0 / h(n - 2), b = 1.0 / h(0);
      s[0] = (3.0 * (a * chord(n - 2) + b * chord(0)) - a * s[n - 2] - b * s[1]) / (2.0 * (a + b));
    } else {
      s[0] = 0.5 * (3.0 * chord(0) - s[1]);
    }
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double a = 1.0 / h(i - 1), b = 1.0 / h(i);
      s[i] = (3.0 * (a * chord(i - 1) + b * chord(i)) - a * s[i - 1] - b * s[i + 1]) / (2.0 * (a + b));
    }
    s[n - 1] = periodic ? s[0] : 0.5 * (3.0 * chord(n - 2) - s[n - 2]);
  }
  return s;
}

std::vector<double> akima_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  const int n = static_cast<int>(x.size());
  // Chords with two more at either end, continued as a parabola would.
  std::vector<double> m(n + 3);
  for (int i = 0; i + 1 < n; ++i) m[i + 2] = (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
  const double second = n > 2 ? m[3] : m[2], last_but_one = n > 2 ? m[n - 1] : m[n];
  m[1] = 2.0 * m[2] - second;
  m[0] = 2.0 * m[1] - m[2];
  m[n + 1] = 2.0 * m[n] - last_but_one;
  m[n + 2] = 2.0 * m[n + 1] - m[n];
  std::vector<double> s(n);
  for (int i = 0; i < n; ++i) {
    const double w_1 = std::abs(m[i + 3] - m[i + 2]), w_2 = std::abs(m[i + 1] - m[i]);
    s[i] = w_1 + w_2 > 0.0 ? (w_1 * m[i + 1] + w_2 * m[i + 2]) / (w_1 + w_2) : 0.5 * (m[i + 1] + m[i + 2]);
  }
  return s;
}

}  // namespace

Curve::Curve(std::vector<double> x, std::vector<double> y, Interpolation interpolation, Outside outside)
    : x_(std::move(x)), outside_(outside) {
  const std::size_t n = x_.size();
  if (n != y.size())
    throw std::invalid_argument(fmt::format("has {} x and {} y; one y belongs to each x", n, y.size()));
  if (n < 2) throw std::invalid_argument("has fewer than 2 points; give at least two");
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(x_[i]) || !std::isfinite(y[i]))
      throw std::invalid_argument("holds a number that is not finite; correct it there");
    if (i > 0 && !(x_[i] > x_[i - 1]))
      throw std::invalid_argument(fmt::format("has x = {} after x = {}; x must rise", x_[i], x_[i - 1]));
  }
  if (outside == Outside::repeat && std::abs(y[n - 1] - y[0]) > 1e-12 * (std::abs(y[0]) + std::abs(y[n - 1])))
    throw std::invalid_argument(fmt::format("repeats, but starts at {} and ends at {}", y[0], y[n - 1]));

  std::vector<double> s;
  if (interpolation == Interpolation::cubic) s = spline_slopes(x_, y, outside == Outside::repeat);
  if (interpolation == Interpolation::akima) s = akima_slopes(x_, y);
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = x_[i + 1] - x_[i], chord = (y[i + 1] - y[i]) / h;
    Piece piece{y[i], chord, 0.0, 0.0, sum};
    if (!s.empty()) {
      piece.c1 = s[i];
      piece.c2 = (3.0 * chord - 2.0 * s[i] - s[i + 1]) / h;
      piece.c3 = (s[i] + s[i + 1] - 2.0 * chord) / (h * h);
    }
    sum += h * (piece.c0 + h * (piece.c1 / 2 + h * (piece.c2 / 3 + h * piece.c3 / 4)));
    pieces_.push_back(piece);
  }
  whole_ = sum;
  const Piece& last = pieces_.back();
  const double h = x_[n - 1] - x_[n - 2], extends = outside == Outside::extend ? 1.0 : 0.0;
  before_ = {y[0], extends * pieces_[0].c1, 0.0, 0.0, 0.0};
  after_ = {y[n - 1], extends * (last.c1 + h * (2.0 * last.c2 + 3.0 * h * last.c3)), 0.0, 0.0, sum};
  at_zero_ = antiderivative(0.0);
  find_kinks();
}

double Curve::periods(double x) const {
  return outside_ == Outside::repeat ? std::floor((x - x_.front()) / (x_.back() - x_.front())) : 0.0;
}

void Curve::find_kinks() {
  const std::size_t n = x_.size();
  bounds_ = over_pieces(x_.front(), x_.back());
  const double range = bounds_.value.width();
  // Slope and second derivative at the end of piece i.
  const auto at_end = [&](std::size_t i) {
    const Piece& c = pieces_[i];
    const double h = x_[i + 1] - x_[i];
    return std::pair(c.c1 + h * (2.0 * c.c2 + 3.0 * c.c3 * h), 2.0 * c.c2 + 6.0 * c.c3 * h);
  };
  int count = 0;
  kinks_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool first = i == 0, last = i + 1 == n;
    double before = before_.c1, bends_before = 0.0, after = after_.c1, bends_after = 0.0;
    double h = first ? x_[1] - x_[0] : x_[i] - x_[i - 1];
    if (!first || outside_ == Outside::repeat) std::tie(before, bends_before) = at_end(first ? n - 2 : i - 1);
    if (!last || outside_ == Outside::repeat) {
      const Piece& c = pieces_[last ? 0 : i];
      after = c.c1;
      bends_after = 2.0 * c.c2;
    }
    if (!first && !last) h = std::max(h, x_[i + 1] - x_[i]);
    count += std::abs(after - before) * h > 1e-4 * range ||
             std::abs(bends_after - bends_before) * h * h > 1e-3 * range;
    kinks_[i] = count;
  }
}

double Curve::kinks_until(double x) const {
  const double k = periods(x);
  x -= k * (x_.back() - x_.front());
  // The first and the last point of a repeated curve are one.
  const bool repeats = outside_ == Outside::repeat;
  const auto i = std::upper_bound(x_.begin(), repeats ? x_.end() - 1 : x_.end(), x) - x_.begin();
  const int in_period = repeats ? kinks_[kinks_.size() - 2] : 0;
  return k * in_period + (i > 0 ? kinks_[static_cast<std::size_t>(i - 1)] : 0);
}

Interval Curve::between_kinks(double x) const {
  const double infinity = std::numeric_limits<double>::infinity();
  const double period = outside_ == Outside::repeat ? x_.back() - x_.front() : 0.0,
               shift = periods(x) * period;
  x -= shift;
  const auto n = static_cast<long>(x_.size());
  const auto is_kink = [&](long i) {
    return kinks_[static_cast<std::size_t>(i)] > (i > 0 ? kinks_[static_cast<std::size_t>(i - 1)] : 0);
  };
  const long next = std::upper_bound(x_.begin(), x_.end(), x) - x_.begin();
  Interval out(-infinity, infinity);
  for (long i = next - 1; i >= 0 && out.lo == -infinity; --i)
    if (is_kink(i)) out.lo = x_[static_cast<std::size_t>(i)] + shift;
  for (long i = next; i < n && out.hi == infinity; ++i)
    if (is_kink(i)) out.hi = x_[static_cast<std::size_t>(i)] + shift;
  if (period == 0.0 || kinks_.back() == 0) return out;
  // The last one of the period before, the first one of the next.
  for (long i = n - 2; i >= 0 && out.lo == -infinity; --i)
    if (is_kink(i)) out.lo = x_[static_cast<std::size_t>(i)] + shift - period;
  for (long i = 1; i < n && out.hi == infinity; ++i)
    if (is_kink(i)) out.hi = x_[static_cast<std::size_t>(i)] + shift + period;
  return out;
}

// Pieces that [a, b], within one period, has a share of.
Curve::Bounds Curve::over_pieces(double a, double b) const {
  Bounds all;
  bool any = false;
  const auto take = [&](const Piece& c, const Interval& u) {
    const Bounds part{Interval(c.c0) + u * (Interval(c.c1) + u * (Interval(c.c2) + u * Interval(c.c3))),
                      Interval(c.c1) + u * (Interval(2.0 * c.c2) + u * Interval(3.0 * c.c3)),
                      Interval(2.0 * c.c2) + u * Interval(6.0 * c.c3)};
    all =
        any ? Bounds{hull(all.value, part.value), hull(all.first, part.first), hull(all.second, part.second)}
            : part;
    any = true;
  };
  if (a < x_.front()) take(before_, {a - x_.front(), std::min(b, x_.front()) - x_.front()});
  if (b >= x_.front() && a <= x_.back())
    for (std::size_t i = piece_of(std::max(a, x_.front())); i < pieces_.size() && x_[i] <= b; ++i)
      take(pieces_[i], {std::max(a, x_[i]) - x_[i], std::min(b, x_[i + 1]) - x_[i]});
  if (b > x_.back()) take(after_, {std::max(a, x_.back()) - x_.back(), b - x_.back()});
  return all;
}

Curve::Bounds Curve::over(const Interval& x) const {
  double a = x.lo, b = x.hi;
  if (outside_ == Outside::repeat) {
    const double period = x_.back() - x_.front(), k = periods(a);
    if (!(b - a < period)) return bounds_;
    a -= k * period;
    b -= k * period;
    if (b > x_.back()) {
      const Bounds one = over({a, x_.back()}), other = over({x_.front(), b - period});
      return {hull(one.value, other.value), hull(one.first, other.first), hull(one.second, other.second)};
    }
  }
  // Over many pieces that of all of them does, so that one question costs little.
  constexpr std::size_t many = 16;
  if (std::isfinite(a) && std::isfinite(b) && piece_of(b) - piece_of(a) <= many) return over_pieces(a, b);
  Bounds all = bounds_;
  for (const auto& [outside, piece] :
       {std::pair(Interval(a - x_.front(), 0.0), &before_), std::pair(Interval(0.0, b - x_.back()), &after_)})
    if (outside.lo < 0.0 || outside.hi > 0.0) {
      if (outside.lo > outside.hi) continue;
      all.value = hull(all.value, Interval(piece->c0) + outside * Interval(piece->c1));
      all.first = hull(all.first, piece->c1);
      all.second = hull(all.second, 0.0);
    }
  return all;
}

std::size_t Curve::piece_of(double x) const {
  const auto next = std::upper_bound(x_.begin(), x_.end(), x);
  const auto i = static_cast<std::size_t>(next - x_.begin());
  return std::min(std::max<std::size_t>(i, 1), pieces_.size()) - 1;
}

Curve::Value Curve::at(double x) const {
  if (outside_ == Outside::repeat) {
    const double period = x_.back() - x_.front();
    x -= period * std::floor((x - x_.front()) / period);
  }
  const bool below = x<x_.front(), above = x> x_.back();
  const std::size_t i = below || above ? 0 : piece_of(x);
  const Piece& c = below ? before_ : above ? after_ : pieces_[i];
  const double u = x - (below ? x_.front() : above ? x_.back() : x_[i]);
  return {c.c0 + u * (c.c1 + u * (c.c2 + u * c.c3)), c.c1 + u * (2.0 * c.c2 + 3.0 * u * c.c3),
          2.0 * c.c2 + 6.0 * u * c.c3, 6.0 * c.c3};
}

double Curve::antiderivative(double x) const {
  double periods = 0.0;
  if (outside_ == Outside::repeat) {
    const double period = x_.back() - x_.front(), k = std::floor((x - x_.front()) / period);
    periods = k * whole_;
    x -= k * period;
  }
  const bool below = x<x_.front(), above = x> x_.back();
  const std::size_t i = below || above ? 0 : piece_of(x);
  const Piece& c = below ? before_ : above ? after_ : pieces_[i];
  const double u = x - (below ? x_.front() : above ? x_.back() : x_[i]);
  return periods + c.sum + u * (c.c0 + u * (c.c1 / 2 + u * (c.c2 / 3 + u * c.c3 / 4)));
}

}  // namespace flexura::mbs
