// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "mbs/base/math/rotation.hpp"

namespace flexura::mbs::chance {

/// Numbers from a seed, the same on every machine: splitmix64 (Steele, Lea, Flood, OOPSLA 2014). The standard's
/// distributions differ between libraries.  Compilers order the arguments of a call as they like: two numbers of one
/// statement are drawn within braces.
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : state_(seed) {
    state_ = bits();  // neighbours would give the same numbers, one later
  }

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  double between(double a, double b) { return a + (b - a) * static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  /// Of either sign, the size between a and b.
  double either_sign(double a, double b) {
    const double size = between(a, b);
    return flip(0.5) ? size : -size;
  }
  /// 0 .. n - 1.
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint64_t>(n)); }
  bool flip(double probability) { return between(0.0, 1.0) < probability; }
  template <class T, std::size_t n>
  const T& one_of(const T (&list)[n]) {
    return list[below(static_cast<int>(n))];
  }
  Vector3d vector(double size) {
    const double x = between(-size, size), y = between(-size, size), z = between(-size, size);
    return {x, y, z};
  }
  Vector3d direction() {
    for (;;) {
      const Vector3d d = vector(1.0);
      if (d.norm() > 0.1 && d.norm() < 1.0) return d.normalized();
    }
  }
  Matrix3d rotation() {
    const Vector3d axis = direction();
    return rotation_exp(between(0.0, std::numbers::pi) * axis);
  }

 private:
  std::uint64_t state_;
};

}  // namespace flexura::mbs::chance
