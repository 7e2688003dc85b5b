// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "mbs/base/math/interval.hpp"

/// What a function of time and its first two derivatives are within, over an interval of time: the rules of jets on
/// intervals (R. E. Moore, Interval Analysis, 1966).
namespace flexura::mbs {

/// f, f', f''.
struct IntervalJet {
  Interval value, first, second;
};

IntervalJet operator+(const IntervalJet& a, const IntervalJet& b);
IntervalJet operator-(const IntervalJet& a, const IntervalJet& b);
IntervalJet operator*(const IntervalJet& a, const IntervalJet& b);
IntervalJet operator/(const IntervalJet& a, const IntervalJet& b);
IntervalJet hull(const IntervalJet& a, const IntervalJet& b);
IntervalJet chain(const IntervalJet& f, const IntervalJet& x);
bool is_constant(const IntervalJet& x);

/// Of the operations (operations.hpp) that are smooth: value and derivatives by x, over x.
IntervalJet smooth_unary(int code, const Interval& x);

/// Which branches of a formula were taken, in the order in which they were met.
struct Branches {
  std::uint64_t hash = 1469598103934665603ULL;
  void note(int node, double branch) {
    for (const std::uint64_t x :
         {static_cast<std::uint64_t>(node), static_cast<std::uint64_t>(static_cast<std::int64_t>(branch))})
      hash = (hash ^ x) * 1099511628211ULL;
  }
};

}  // namespace flexura::mbs
