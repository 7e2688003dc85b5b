// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "mbs/solver/accuracy/options.hpp"

/// At which times a run gives rows, and at which others look at it between them.
namespace flexura::mbs {

class RowTimes {
 public:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  /// Rows from options.start_time to its end_time, options.output_step apart, the last at the end time even where the
  /// step does not divide the run; looks at these times [s], in their order.
  RowTimes(const SolverOptions& options, std::vector<double> looks);

  /// The number of the row that has not been given yet; 0 is the start.
  long next() const { return next_; }
  bool is_row_until(double t) const { return at(next_) <= t && at(next_) > at(next_ - 1); }
  /// The time of the next row, which is given by this.
  double take_row() { return at(next_++); }
  /// The next look, if it lies before the next row and until t; else kNever.
  double look_until(double t) const;
  void take_look() { ++next_look_; }
  /// Looks until t are past.
  void pass_looks(double t);
  /// At t, in a run that was saved when `said` was its next row.  Throws std::invalid_argument where that cannot be.
  void go_on_from(double t, long said);

 private:
  double at(long k) const;
  double nearly(double t) const;  // two rows at t are one

  double start_, end_, apart_;
  std::vector<double> looks_;
  long n_ = 0, next_ = 1;
  std::size_t next_look_ = 0;
};

}  // namespace flexura::mbs
