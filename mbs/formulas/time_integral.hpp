// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <mutex>
#include <vector>

#include "mbs/formulas/time_function.hpp"

namespace flexura::mbs {

/// The integral of a function of time from 0, to round-off: what a drive that is given by its acceleration has made of the
/// speed.  Time is divided until interval arithmetic proves each panel smooth (TimeFunction), so that no pulse is stepped
/// over however short, and each panel is integrated by the rule of Gauss and Kronrod of 7 and 15 points (R. Piessens et al.,
/// QUADPACK, Springer 1983).  Panels are made once, as far as has been asked, and kept: an evaluation costs 15 of the function.
class TimeIntegral {
 public:
  explicit TimeIntegral(TimeFunction f) : f_(std::move(f)) {}

  /// Of f from 0 to t, whose sign is any.  May be asked by several threads.  Throws std::runtime_error, naming the element
  /// and the time, where f has no value or no panels can be made.
  double operator()(double t) const;

 private:
  struct Panel {
    double end;     ///< where it ends; it begins where the one before ends, the first at 0
    double before;  ///< the integral until its begin
  };
  /// Of one direction of time.
  struct Side {
    std::vector<Panel> panels;
    double reached = 0.0, total = 0.0;
  };
  void extend(Side& side, double sign, double until) const;
  double over(double a, double b, int halvings) const;

  TimeFunction f_;
  mutable std::mutex guard_;
  mutable Side forward_, backward_;
};

}  // namespace flexura::mbs
