// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/mbs/flexible/beam_superelement.hpp"

/// Mechanisms of many kinds whose motion is known without the program, in any size, weight and pace.
namespace flexura::extremes {

/// Unit systems are numbers: what is 1 m and 1 kg is 1000 and 0.001 in mm-t-s.
struct Scales {
  double mass = 1.0, length = 1.0, time = 1.0;
  double ratio =
      1.0;  ///< of masses, of those that have several bodies (below 1 where else something would vibrate fast)
  double damping = 0.0;  ///< ratio, of those that are linear
  double gap =
      0.5;  ///< of those that are driven: how far, over the crank's length, they stay from a position that has no way on
};

/// A mechanism at one place of an axis: its file, and what its first output is in truth.
struct Scene {
  std::string text;  ///< without [solver] and [output]
  std::string output;
  double end_time = 0.0;  ///< two periods or as much
  double scale = 1.0;     ///< the output's, for relative errors
  std::function<double(double time)> exact;
  std::optional<mbs::beams::StraightBeam> bar;  ///< that bar.se.h5 beside it is made of
};

/// Draws of one seed: the same ones on every machine (the generator of the standard, no distribution of it).
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : twister_(seed) {}
  double within(double from, double to) {
    return from + (to - from) * static_cast<double>(twister_() >> 11) * 0x1p-53;
  }
  /// Uniform in the logarithm.
  double decades(double from, double to);

 private:
  std::mt19937_64 twister_;
};

struct Mechanism {
  const char* name;
  std::function<Scene(const Scales&, Chance&)> make;
};

/// Linear ones, exact in closed form, with damping: a mass on a rail, a wheel on a torsion spring, a free body on a
/// bushing, a mass on a spring between points, and a parallelogram of three bodies, which closes a loop.
const std::vector<Mechanism>& linear_mechanisms();
/// Others: a swinging bar, a double pendulum, a slider-crank on a torsion spring, a tumbling body, all by the test's own
/// equations of motion, and an elastic cantilever under a sudden load by its series of modes.
const std::vector<Mechanism>& other_mechanisms();

/// Driven through a turn in 2 pi units of time, exact by trigonometry: a slider-crank whose rod is the crank and the gap long, a four-bar
/// linkage that is Grashof's by the gap, and a crank that guides a bar through a swivel, past which its pin goes at the gap.
const std::vector<Mechanism>& driven_mechanisms();

}  // namespace flexura::extremes
