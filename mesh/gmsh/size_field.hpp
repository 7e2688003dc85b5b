// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

/// Element sizes given at points: everywhere the size of the nearest point, found by a grid of buckets.
namespace flexura::mesh {

class SizeField {
 public:
  /// x, y, z, size of each point.
  explicit SizeField(const std::vector<double>& points) : points_(points) {
    const std::size_t n = points_.size() / 4;
    std::array<double, 3> high;
    low_.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t k = 0; k < n; ++k)
      for (int d = 0; d < 3; ++d) {
        low_[d] = std::min(low_[d], points_[4 * k + d]);
        high[d] = std::max(high[d], points_[4 * k + d]);
      }
    // About one point in a bucket, were they spread evenly.
    double volume = 1.0, longest = 0.0;
    for (int d = 0; d < 3; ++d) longest = std::max(longest, high[d] - low_[d]);
    for (int d = 0; d < 3; ++d) volume *= std::max(high[d] - low_[d], 1e-3 * longest);
    width_ = std::max(std::cbrt(volume / static_cast<double>(std::max<std::size_t>(n, 1))), 1e-3 * longest);
    if (!(width_ > 0.0)) width_ = 1.0;
    for (int d = 0; d < 3; ++d) count_[d] = static_cast<int>((high[d] - low_[d]) / width_) + 1;
    first_.assign(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2] + 1, 0);
    for (std::size_t k = 0; k < n; ++k) ++first_[bucket(place(&points_[4 * k])) + 1];
    for (std::size_t b = 1; b < first_.size(); ++b) first_[b] += first_[b - 1];
    in_.resize(n);
    std::vector<int> next(first_.begin(), first_.end() - 1);
    for (std::size_t k = 0; k < n; ++k)
      in_[static_cast<std::size_t>(next[bucket(place(&points_[4 * k]))]++)] = static_cast<int>(k);
  }

  /// `distance`, where given, becomes that of the nearest point.
  double at(double x, double y, double z, double* distance = nullptr) const {
    const double p[3] = {x, y, z};
    const std::array<int, 3> c = place(p);
    double best = std::numeric_limits<double>::infinity(), size = 0.0;
    const int last = std::max({count_[0], count_[1], count_[2]});
    // Buckets in shells around that of the point; what lies beyond shell r is farther than r widths, less the way
    // from the point to the grid.
    for (int r = 0; r <= last; ++r) {
      for (int i = std::max(c[0] - r, 0); i <= std::min(c[0] + r, count_[0] - 1); ++i)
        for (int j = std::max(c[1] - r, 0); j <= std::min(c[1] + r, count_[1] - 1); ++j) {
          const bool side = i == c[0] - r || i == c[0] + r || j == c[1] - r || j == c[1] + r;
          for (int k = std::max(c[2] - r, 0); k <= std::min(c[2] + r, count_[2] - 1); ++k) {
            if (!side && k != c[2] - r && k != c[2] + r) continue;
            const std::size_t b = bucket({i, j, k});
            for (int q = first_[b]; q < first_[b + 1]; ++q) {
              const double* point = &points_[4 * static_cast<std::size_t>(in_[static_cast<std::size_t>(q)])];
              const double d = std::hypot(point[0] - x, point[1] - y, point[2] - z);
              if (d < best) best = d, size = point[3];
            }
          }
        }
      if (best <= r * width_) break;
    }
    if (distance) *distance = best;
    return size;
  }

 private:
  std::array<int, 3> place(const double* p) const {
    std::array<int, 3> c;
    for (int d = 0; d < 3; ++d)
      c[d] = static_cast<int>(std::clamp((p[d] - low_[d]) / width_, 0.0, count_[d] - 1.0));
    return c;
  }
  std::size_t bucket(const std::array<int, 3>& c) const {
    return (static_cast<std::size_t>(c[0]) * count_[1] + c[1]) * count_[2] + c[2];
  }

  std::vector<double> points_;
  std::array<double, 3> low_{};
  std::array<int, 3> count_{1, 1, 1};
  double width_ = 1.0;
  std::vector<int> first_, in_;
};

}  // namespace flexura::mesh
