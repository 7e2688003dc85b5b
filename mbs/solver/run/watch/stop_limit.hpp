// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// What is a function of time jumps, bends or turns, and no step passes that: so often that a run would never end it is refused.
namespace flexura::mbs {

class StopLimit {
 public:
  /// `what` these functions do, for the message; no more than `most` times in a run until t_end [s].
  StopLimit(const char* what, double most, double t_end) : what_(what), most_(most), t_end_(t_end) {}

  void begin(double t) { since_ = t; }
  /// One at the time t [s].  Throws IntegrationError.
  void count(double t);

 private:
  const char* what_;
  double most_, t_end_, since_ = 0.0;
  long n_ = 0;
};

}  // namespace flexura::mbs
