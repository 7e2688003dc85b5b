// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <string>

/// Tells motion that grows without bound from motion that is long or fast.
///
/// What grows exponentially (an unstable control, a damper of negative sign, a body past the load under which
/// it is stable) takes equal times for every factor of ten of its kinetic energy; under forces that are
/// bounded, energy grows like a power t^p of time, and each factor of ten takes 10^(1/p) times as long as the
/// one before.  So the motion has no bound where the energy, at its highest so far, grew tenfold ten times in
/// a row, in at least eight rows, the last five times no slower than the first five (by a quarter: p above 50
/// passes for no bound), and something has travelled by more than 1000 m or rad meanwhile: what swings away
/// from an unstable equilibrium grows so, too, but comes to an end within its own size.
///
/// Faster than a tenth of light nothing here is right: Newton's equations are wrong by half a percent there.
namespace flexura::mbs {

class GrowthWatch {
 public:
  /// A row: kinetic energy [J], the farthest that a coordinate is from its start [m or rad], and the speed of
  /// the fastest body [m/s].
  void observe(double t, double kinetic, double travel, double speed);

  /// Why the motion is no result any more; empty where it is one.
  const std::string& reason() const { return reason_; }
  /// Of a run that goes on no further: what it says where the energy grew tenfold six times, far away or in equal times, too few to
  /// be sure; else empty.
  std::string suspicion() const;

 private:
  struct Decade {
    double t = 0.0;  ///< when the energy first was as high
    long row = 0;    ///< the row before
    double travel = 0.0;
  };
  void pass(double t, double energy, double travel);
  std::string since(std::size_t decades, double energy) const;

  double t_before_ = 0.0, highest_ = 0.0;
  long row_ = 0;
  std::deque<Decade> decades_;
  std::string reason_;
};

}  // namespace flexura::mbs
