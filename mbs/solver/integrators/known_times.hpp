// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/accuracy/options.hpp"

/// Where a run has to stop because of what is known of it beforehand: times at which functions of time jump or
/// have a kink, and how far a step may reach where one is at work.
///
/// The run's span is halved again and again, the earliest part first and only as far as the run looks ahead,
/// until each part of a function (TimeFunction::over)
///
///   - holds a jump or a kink between two neighbouring numbers: an event; or
///   - is quiet: whatever it does besides a straight line is worth less than 1e-13 of its range times the span
///     (an impulse): steps may pass over it; or
///   - is one with itself: its second derivative varies by no more than it is large.  Three such parts are as
///     far as a step may reach: a quarter to three quarters of a period of a sine.
///
/// A fixed step that is longer than such a part gives way to quarters of it.
///
/// Nothing is stored but what lies ahead of the step, and where the parts are follows from the span alone: a
/// continued run finds the same ones to the bit.
namespace flexura::mbs {

class KnownTimes {
 public:
  KnownTimes(const Equations& eq, const SolverOptions& options);
  ~KnownTimes();

  struct Stop {
    double t = std::numeric_limits<double>::infinity();  ///< the last moment before it
    bool is_event = false;                               ///< else only a step's bound
    double after = 0.0;                                  ///< the first moment behind an event
    bool is_due = false;                                 ///< the event is too close for a step
  };
  /// The next one from t on; one that is due is returned until it is passed.
  Stop next(double t);
  void pass(const Stop& stop) { passed_ = stop.after; }

  /// Times [s], in their order, at which to look so that nothing is missed between rows that lie `apart` [s]: where
  /// these times follow one another more closely than 2 `apart`, kLooks between two events, four for each bound of a
  /// step; ever longer after each other behind an event.  No more than `most`; `is_all` is false where that is not enough.
  struct Looks {
    std::vector<double> t;
    bool is_all = true;
  };
  static Looks looks(const Equations& eq, const SolverOptions& options, double apart, std::size_t most);

  /// The shortest time from one to the next that is below `limit` [s], 0 where there is none: what rows that
  /// far apart do not show.
  static double shortest(const Equations& eq, const SolverOptions& options, double limit);

 private:
  class Scan;
  static constexpr int kLooks =
      12;  // sin^2 from end to end: its impulse and its square by the trapezoidal rule
  /// What lies between two stops, from where functions of time begin to bend.
  struct Stretch {
    double begin, end;
    bool ends_at_event;
  };
  /// Calls take(stretch) for one after the other until it returns false, for a run's whole span.
  static void for_each(const Equations& eq, const SolverOptions& options,
                       const std::function<bool(const Stretch&)>& take);
  std::vector<std::unique_ptr<Scan>> scans_;
  double begin_, end_, reach_, passed_, fixed_step_, last_bound_begin_ = 0.0;
};

}  // namespace flexura::mbs
