// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <string>

#include "tests/mbs/app/extremes_scenes.hpp"

/// Numbers of a scene as a file has them.
namespace flexura::extremes {

// A number with all its digits, in one unit of the scene.
inline std::string n(double x) {
  return fmt::format("{:.17g}", x);
}
inline std::string list(double x, double y, double z) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", x, y, z);
}

struct Units {
  explicit Units(const Scales& s)
      : mass(s.mass),
        length(s.length),
        time(s.time),
        inertia(s.mass * s.length * s.length),
        force(s.mass * s.length / (s.time * s.time)),
        stiffness(force / s.length),
        torque(force * s.length) {}
  double mass, length, time, inertia, force, stiffness, torque;
};

}  // namespace flexura::extremes
