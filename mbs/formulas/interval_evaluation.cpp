// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/interval_evaluation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "mbs/formulas/operations.hpp"

namespace flexura::mbs {

using namespace operations;

namespace {
// Arguments of any operation but minimum and maximum.
constexpr std::size_t kFew = 5;
}  // namespace

// Of x > 0 (or >= 0), with room for round-off of what x is made of.
IntervalEvaluation::Truth IntervalEvaluation::positive(const Interval& x, double size) {
  const double room = 2e-16 * size;
  return x.lo > room ? Truth::yes : x.hi < -room ? Truth::no : Truth::open;
}

IntervalEvaluation::Truth IntervalEvaluation::truth(const IntervalJet& x) {
  return x.value.lo == 0.0 && x.value.hi == 0.0 ? Truth::no
         : x.value.contains(0.0)                ? Truth::open
                                                : Truth::yes;
}

IntervalJet IntervalEvaluation::say(Truth truth) {
  if (truth == Truth::open) return {{0.0, 1.0}, 0.0, 0.0};
  return {truth == Truth::yes ? 1.0 : 0.0, 0.0, 0.0};
}

bool IntervalEvaluation::is_held(const FormulaNode& node) const {
  return node.held > 0 && node.code != table && signals_[node.held].value.lo != 0.0;
}

// As Expression takes it.
IntervalJet IntervalEvaluation::held(const FormulaNode& node, std::span<const IntervalJet> x) const {
  const double at = held_integer(static_cast<int>(signals_[node.held].value.lo));
  const IntervalJet constant{at, 0.0, 0.0};
  switch (node.code) {
    case modulo:
      return x[0] - constant * x[1];
    case minimum:
    case maximum:
      return x[std::min(x.size() - 1, static_cast<std::size_t>(at))];
    case absolute:
      return IntervalJet{at != 0.0 ? 1.0 : -1.0, 0.0, 0.0} * x[0];
    default:
      return constant;
  }
}

IntervalJet IntervalEvaluation::compare(int k, const IntervalJet& a, const IntervalJet& b) {
  const int code = tree_[k].code;
  const double size = a.value.magnitude() + b.value.magnitude();
  if (code == equal || code == not_equal) {
    Truth same = positive(a.value - b.value, size) == Truth::open ? Truth::open : Truth::no;
    if (same == Truth::open && is_constant(a) && is_constant(b) && a.value.width() == 0.0 &&
        b.value.width() == 0.0)
      same = a.value.lo == b.value.lo ? Truth::yes : Truth::no;
    if (same == Truth::open)
      is_decided = false;
    else
      branches.note(k, (same == Truth::yes) == (code == equal));
    if (same != Truth::open && code == not_equal) same = same == Truth::yes ? Truth::no : Truth::yes;
    return say(same);
  }
  const bool rising = code == greater || code == greater_equal;
  Truth truth = positive(rising ? a.value - b.value : b.value - a.value, size);
  // What does not change is as it is.
  if (truth == Truth::open && a.value.width() == 0.0 && b.value.width() == 0.0 && is_constant(a) &&
      is_constant(b)) {
    const double x = a.value.lo, y = b.value.lo;
    truth = (code == less            ? x < y
             : code == less_equal    ? x <= y
             : code == greater_equal ? x >= y
                                     : x > y)
                ? Truth::yes
                : Truth::no;
  }
  if (truth == Truth::open)
    is_decided = false;
  else
    branches.note(k, truth == Truth::yes);
  return say(truth);
}

IntervalJet IntervalEvaluation::rounded(int k, const Interval& x) {
  const int code = tree_[k].code == modulo ? static_cast<int>(round_down) : tree_[k].code;
  const double room = 2e-16 * x.magnitude(), low = apply_unary(code, x.lo - room),
               high = apply_unary(code, x.hi + room);
  if (low == high || x.width() == 0.0)
    branches.note(k, apply_unary(code, x.lo));
  else
    is_decided = false;
  if (x.width() == 0.0) return {apply_unary(code, x.lo), 0.0, 0.0};
  return {Interval::of(low, high), 0.0, 0.0};
}

IntervalJet IntervalEvaluation::extreme(int k, std::span<const IntervalJet> x) {
  const bool least = tree_[k].code == minimum;
  for (std::size_t i = 0; i < x.size(); ++i) {
    bool wins = true;
    for (std::size_t j = 0; j < x.size() && wins; ++j) {
      if (i == j) continue;
      const Interval lead = least ? x[j].value - x[i].value : x[i].value - x[j].value;
      wins = positive(lead, x[i].value.magnitude() + x[j].value.magnitude()) == Truth::yes;
    }
    if (!wins) continue;
    branches.note(k, static_cast<double>(i));
    return x[i];
  }
  bool constants = true;
  for (const IntervalJet& one : x) constants = constants && is_constant(one) && one.value.width() == 0.0;
  IntervalJet all = x[0];
  for (const IntervalJet& one : x) {
    const Interval value =
        least ? Interval(std::min(all.value.lo, one.value.lo), std::min(all.value.hi, one.value.hi))
              : Interval(std::max(all.value.lo, one.value.lo), std::max(all.value.hi, one.value.hi));
    all = hull(all, one);
    all.value = value;
  }
  if (!constants) is_decided = false;
  return all;
}

IntervalJet IntervalEvaluation::step(int k, std::span<const IntervalJet> x) {
  const IntervalJet &at = x[0], &x_0 = x[1], &y_0 = x[2], &x_1 = x[3], &y_1 = x[4];
  const Truth behind_0 = positive(at.value - x_0.value, at.value.magnitude() + x_0.value.magnitude()),
              behind_1 = positive(at.value - x_1.value, at.value.magnitude() + x_1.value.magnitude());
  if (behind_0 == Truth::no) return branches.note(k, -1), y_0;
  if (behind_0 == Truth::yes && behind_1 == Truth::yes) return branches.note(k, 1), y_1;
  IntervalJet u = (at - x_0) / (x_1 - x_0);
  if (!u.value.is_finite()) u.value = {0.0, 1.0};
  u.value = {std::clamp(u.value.lo, 0.0, 1.0), std::clamp(u.value.hi, 0.0, 1.0)};
  const auto rise = [](double v) { return v * v * (3.0 - 2.0 * v); };
  const Interval v = u.value;
  const IntervalJet s{
      {rise(v.lo), rise(v.hi)}, Interval(6.0) * v * (Interval(1.0) - v), Interval(6.0) - Interval(12.0) * v};
  const IntervalJet between = y_0 + (y_1 - y_0) * chain(s, u);
  if (behind_0 == Truth::yes && behind_1 == Truth::no) return branches.note(k, 0), between;
  is_decided = false;
  IntervalJet all = between;
  if (behind_0 == Truth::open) all = hull(all, y_0);
  if (behind_1 == Truth::open) all = hull(all, y_1);
  return all;
}

IntervalJet IntervalEvaluation::operator()(int k) {
  const FormulaNode& node = tree_[k];
  // Branches that are not taken are not looked at.
  if (node.code == choice) {
    const Truth which = truth((*this)(node.args[0]));
    if (which != Truth::open) branches.note(k, which == Truth::yes);
    if (which == Truth::yes) return (*this)(node.args[1]);
    if (which == Truth::no) return (*this)(node.args[2]);
    is_decided = false;
    const IntervalJet yes = (*this)(node.args[1]);
    return hull(yes, (*this)(node.args[2]));
  }
  if (node.code == logical_and || node.code == logical_or) {
    const Truth enough = node.code == logical_or ? Truth::yes : Truth::no;
    const Truth a = truth((*this)(node.args[0]));
    if (a == enough) return say(a);
    const Truth b = truth((*this)(node.args[1]));
    if (a == Truth::open || b == Truth::open) is_decided = false;
    return say(b == enough ? b : a == Truth::open ? a : b);
  }
  // On the stack: this runs in every step of an integrator.
  std::array<IntervalJet, kFew> few;
  std::vector<IntervalJet> many;
  if (node.args.size() > kFew) many.resize(node.args.size());
  const std::span<IntervalJet> x(many.empty() ? few.data() : many.data(), node.args.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = (*this)(node.args[i]);
  if (is_held(node)) return held(node, x);
  switch (node.code) {
    case constant:
      return {node.value, 0.0, 0.0};
    case signal:
      return signals_[node.place];
    case add:
      return x[0] + x[1];
    case subtract:
      return x[0] - x[1];
    case multiply:
      return x[0] * x[1];
    case divide:
      return x[0] / x[1];
    case power: {
      if (!is_constant(x[1]) || x[1].value.width() > 0.0)
        return chain(smooth_unary(exponential, x[1].value * log(x[0].value)),
                     x[1] * chain(smooth_unary(logarithm, x[0].value), x[0]));
      const double n = x[1].value.lo;
      const Interval at = x[0].value;
      // All powers of what is positive rise or fall, and each is the next higher one over x.
      if (at.lo > 0.0 && at.is_finite()) {
        double low = std::pow(at.lo, n), high = at.lo == at.hi ? low : std::pow(at.hi, n);
        IntervalJet f;
        f.value = {std::min(low, high), std::max(low, high)};
        low /= at.lo, high /= at.hi;
        f.first = Interval(n) * Interval{std::min(low, high), std::max(low, high)};
        low /= at.lo, high /= at.hi;
        f.second = Interval(n * (n - 1.0)) * Interval{std::min(low, high), std::max(low, high)};
        return chain(f, x[0]);
      }
      const auto derivative = [&](double factor, double exponent) {
        return factor == 0.0 ? Interval(0.0) : Interval(factor) * pow(x[0].value, exponent);
      };
      return chain({pow(x[0].value, n), derivative(n, n - 1.0), derivative(n * (n - 1.0), n - 2.0)}, x[0]);
    }
    case less:
    case less_equal:
    case greater:
    case greater_equal:
    case equal:
    case not_equal:
      return compare(k, x[0], x[1]);
    case absolute:
    case signum: {
      const Truth side = positive(x[0].value, x[0].value.magnitude());
      const bool still = x[0].value.width() == 0.0 && is_constant(x[0]);
      if (side == Truth::open && !still) {
        is_decided = false;
        if (node.code == signum) return {{-1.0, 1.0}, 0.0, 0.0};
        return {{0.0, x[0].value.magnitude()},
                hull(x[0], IntervalJet{} - x[0]).first,
                hull(x[0], IntervalJet{} - x[0]).second};
      }
      const double s = side == Truth::yes ? 1.0 : side == Truth::no ? -1.0 : 0.0;
      branches.note(k, s);
      return node.code == signum ? IntervalJet{s, 0.0, 0.0} : IntervalJet{s, 0.0, 0.0} * x[0];
    }
    case round_to_integer:
    case round_down:
    case round_up:
      return rounded(k, x[0].value);
    case modulo: {
      const IntervalJet n = rounded(k, (x[0] / x[1]).value);
      IntervalJet rest = x[0] - n * x[1];
      // Wherever it jumps it stays below y.
      if (n.value.width() > 0.0) {
        const Interval y = x[1].value;
        rest.value = {std::min(0.0, y.lo), std::max(0.0, y.hi)};
      }
      return rest;
    }
    case minimum:
    case maximum:
      return extreme(k, x);
    case smooth_step:
      return step(k, x);
    case table: {
      const Interval at = x[0].value;
      if (!at.is_finite()) {
        is_decided = false;
        return {Interval::everywhere(), Interval::everywhere(), Interval::everywhere()};
      }
      const double room = 2e-16 * at.magnitude();
      const double kinks = node.curve->kinks_until(at.lo - room);
      if (kinks == node.curve->kinks_until(at.hi + room) || at.width() == 0.0)
        branches.note(k, node.curve->kinks_until(at.lo));
      else
        is_decided = false;
      const Curve::Bounds f = node.curve->over(at);
      return chain({f.value, f.first, f.second}, x[0]);
    }
    case arc_tangent_2: {
      const Interval y = x[0].value, z = x[1].value;
      // It jumps across the negative half of the second axis.
      if (z.lo < 0.0 && positive(y, y.magnitude()) == Truth::open &&
          !(is_constant(x[0]) && y.width() == 0.0)) {
        is_decided = false;
        return {{-std::numbers::pi, std::numbers::pi}, Interval::everywhere(), Interval::everywhere()};
      }
      if (z.lo < 0.0) branches.note(k, y.lo > 0.0 || (y.lo == 0.0 && y.hi == 0.0) ? 1.0 : -1.0);
      const double corners[] = {std::atan2(y.lo, z.lo), std::atan2(y.lo, z.hi), std::atan2(y.hi, z.lo),
                                std::atan2(y.hi, z.hi)};
      Interval value(*std::min_element(corners, corners + 4), *std::max_element(corners, corners + 4));
      if (y.contains(0.0) && z.contains(0.0)) value = {-std::numbers::pi, std::numbers::pi};
      const Interval r2 = square(y) + square(z);
      IntervalJet f;
      f.value = value;
      f.first = (z * x[0].first - y * x[1].first) / r2;
      f.second =
          (z * x[0].second - y * x[1].second - Interval(2.0) * (z * x[1].first + y * x[0].first) * f.first) /
          r2;
      return f;
    }
    default:
      return chain(smooth_unary(node.code, x[0].value), x[0]);
  }
}

}  // namespace flexura::mbs
