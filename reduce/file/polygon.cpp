// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/polygon.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <optional>

namespace flexura::reduce {
namespace {

using Eigen::Vector2d;
using mesh::PlaneLoop;

struct Side {
  Vector2d from, to;
  std::size_t number;  ///< of its first corner, from 0
};

Vector2d corner(const PlaneLoop& loop, std::size_t k) {
  return {loop[k % loop.size()][0], loop[k % loop.size()][1]};
}

std::vector<Side> sides_of(const PlaneLoop& loop) {
  std::vector<Side> sides;
  for (std::size_t k = 0; k < loop.size(); ++k) sides.push_back({corner(loop, k), corner(loop, k + 1), k});
  return sides;
}

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double distance(const Vector2d& p, const Side& side) {
  const Vector2d d = side.to - side.from;
  const double along = std::clamp((p - side.from).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (side.from + along * d - p).norm();
}

/// Where on `a` (0 to 1) the two cross, ends included; nothing for parallel ones.
std::optional<double> crossing(const Side& a, const Side& b) {
  const Vector2d d = a.to - a.from, e = b.to - b.from, between = b.from - a.from;
  const double det = cross(d, e);
  if (det == 0.0) return {};
  const double along = cross(between, e) / det, other = cross(between, d) / det;
  if (along < 0.0 || along > 1.0 || other < 0.0 || other > 1.0) return {};
  return along;
}

bool meet(const Side& a, const Side& b) {
  return crossing(a, b) || std::min({distance(a.from, b), distance(a.to, b), distance(b.from, a),
                                     distance(b.to, a)}) <= kSamePlace;
}

}  // namespace

PlaneLoop without_repeated(const PlaneLoop& loop, bool closed) {
  PlaneLoop out;
  for (std::size_t k = 0; k < loop.size(); ++k)
    if (out.empty() || (corner(loop, k) - corner(out, out.size() - 1)).norm() > kSamePlace)
      out.push_back(loop[k]);
  while (closed && out.size() > 1 && (corner(out, 0) - corner(out, out.size() - 1)).norm() <= kSamePlace)
    out.pop_back();
  return out;
}

std::string polygon_fault(const PlaneLoop& loop) {
  const std::size_t n = loop.size();
  if (n < 3) return fmt::format("a polygon has {} corner{}; at least 3 are needed", n, n == 1 ? "" : "s");
  const auto place = [&](std::size_t k) { return (k % n) + 1; };
  for (std::size_t k = 0; k < n; ++k) {  // neighbours share a corner, and nothing more
    const Side in = {corner(loop, k), corner(loop, k + 1), k}, out = {in.to, corner(loop, k + 2), k + 1};
    if (std::min(distance(in.from, out), distance(out.to, in)) <= kSamePlace)
      return fmt::format("its outline folds back on itself at corner {}", place(k + 1));
  }
  std::vector<Side> sides = sides_of(loop);
  const auto low = [](const Side& s) { return std::min(s.from.x(), s.to.x()); };
  const auto high = [](const Side& s) { return std::max(s.from.x(), s.to.x()); };
  std::ranges::sort(sides, {}, low);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n && low(sides[j]) <= high(sides[i]) + kSamePlace; ++j) {
      const auto [first, second] = std::minmax(sides[i].number, sides[j].number);
      if (second - first == 1 || second - first == n - 1 || !meet(sides[i], sides[j])) continue;
      return fmt::format(
          "it crosses or touches itself: the side from corner {} to {} meets that from {} to {}",
          place(first), place(first + 1), place(second), place(second + 1));
    }
  return "";
}

double shared_area(const PlaneLoop& a, const PlaneLoop& b) {
  const std::vector<Side> of_a = sides_of(a), of_b = sides_of(b);
  std::vector<double> stops;
  for (const auto* sides : {&of_a, &of_b})
    for (const Side& side : *sides) stops.push_back(side.from.x());
  for (const Side& one : of_a)
    for (const Side& other : of_b)
      if (const auto along = crossing(one, other))
        stops.push_back(one.from.x() + *along * (one.to.x() - one.from.x()));
  std::ranges::sort(stops);
  // Of a polygon at x: pairs of heights between which it lies.
  const auto heights = [](const std::vector<Side>& sides, double x) {
    std::vector<double> out;
    for (const Side& s : sides)
      if ((s.from.x() <= x) != (s.to.x() <= x))
        out.push_back(s.from.y() + (x - s.from.x()) / (s.to.x() - s.from.x()) * (s.to.y() - s.from.y()));
    std::ranges::sort(out);
    return out;
  };
  double area = 0.0;
  for (std::size_t k = 0; k + 1 < stops.size(); ++k) {
    const double width = stops[k + 1] - stops[k], x = stops[k] + 0.5 * width;
    if (!(width > 0.0)) continue;
    const std::vector<double> in_a = heights(of_a, x), in_b = heights(of_b, x);
    for (std::size_t i = 0; i + 1 < in_a.size(); i += 2)
      for (std::size_t j = 0; j + 1 < in_b.size(); j += 2)
        area += width * std::max(0.0, std::min(in_a[i + 1], in_b[j + 1]) - std::max(in_a[i], in_b[j]));
  }
  return area;
}

}  // namespace flexura::reduce
