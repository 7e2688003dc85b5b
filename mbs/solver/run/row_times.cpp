// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/row_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace flexura::mbs {

RowTimes::RowTimes(const SolverOptions& options, std::vector<double> looks)
    : start_(options.start_time),
      end_(options.end_time),
      apart_(options.output_step),
      looks_(std::move(looks)),
      n_(static_cast<long>(std::floor((end_ - start_) / apart_ * (1 + 1e-12)))) {}

// The last row of a step that divides the run is the end, not one a round-off before it and the end again.
double RowTimes::at(long k) const {
  const double t = start_ + static_cast<double>(k) * apart_;
  return k > n_ || t >= end_ - nearly(end_) ? end_ : t;
}

double RowTimes::nearly(double t) const {
  return 1e-9 * apart_ + 1e-14 * std::abs(t);
}

double RowTimes::look_until(double t) const {
  if (next_look_ >= looks_.size()) return kNever;
  const double look = looks_[next_look_];
  return look <= t && look < at(next_) ? look : kNever;
}

void RowTimes::pass_looks(double t) {
  while (next_look_ < looks_.size() && looks_[next_look_] <= t) ++next_look_;
}

void RowTimes::go_on_from(double t, long said) {
  const double close = nearly(t);
  next_ = said;
  // A step may end an ulp before or behind a row.
  if (said >= 1 && said <= n_ + 2 && at(said - 1) <= t + close && at(said) >= t - close) return;
  long k = std::clamp(static_cast<long>((t - start_) / apart_) - 1, 1L, n_ + 1);
  while (at(k) <= t + close && at(k) > at(k - 1)) ++k;
  next_ = k;
  if (said == k + 1) return;  // saved at an end beside the rows' grid, which gave a row of its own
  throw std::invalid_argument(fmt::format(
      "the next row is said to be number {}, and after t = {:.9g} s it is number {}: give the "
      "start_time and the output_step of the run that was saved; where they are, the file was changed",
      said, t, k));
}

}  // namespace flexura::mbs
