// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mbs/formulas/expression.hpp"
#include "mbs/formulas/operations.hpp"

/// The tree of a formula, and its conditions: what is held between events.
namespace flexura::mbs {

using namespace operations;

namespace {

// A road of more points than these keeps steps short by itself.
constexpr int kMostKinks = 1000;

}  // namespace

void Expression::find_conditions(SignalNames& held, const std::vector<int>& node_of) {
  for (std::size_t i = 0; i < program_.size(); ++i) {
    const int k = node_of[i];
    const int code = program_[i].code;
    const bool bends =
        code == absolute || code == minimum || code == maximum ||
        (code == table && tree_[k].curve->kinks() > 0 && tree_[k].curve->kinks() <= kMostKinks);
    if (k < 0 || !(jumps(code) || bends)) continue;
    if (!tree_.any(k, [](const FormulaNode& node) { return node.code == signal && node.place > 0; }))
      continue;
    program_[i].place = tree_.nodes[static_cast<std::size_t>(k)].held = held.add_hidden();
    conditions_.push_back(k);
  }
}

namespace {

bool is_extreme(int code) {
  return code == minimum || code == maximum;
}
bool bends_at(int code) {
  return code == absolute || code == table || is_extreme(code);
}

// At the node, with conditions as they are held, or as they are where they are not.
double value_at(const FormulaTree& tree, int k, const double* signals) {
  const FormulaNode& node = tree[k];
  const auto arg = [&](std::size_t i) { return value_at(tree, node.args[i], signals); };
  if (node.held > 0 && signals[node.held] != 0.0) {
    const double held = held_integer(static_cast<int>(signals[node.held]));
    if (node.code == modulo) return arg(0) - held * arg(1);
    if (!bends_at(node.code)) return held;
  }
  switch (node.code) {
    case constant:
      return node.value;
    case signal:
      return signals[node.place];
    case choice:
      return arg(0) != 0.0 ? arg(1) : arg(2);
    case add:
      return arg(0) + arg(1);
    case subtract:
      return arg(0) - arg(1);
    case multiply:
      return arg(0) * arg(1);
    case divide:
      return arg(0) / arg(1);
    case power:
      return power_of(arg(0), arg(1));
    case less:
      return arg(0) < arg(1);
    case less_equal:
      return arg(0) <= arg(1);
    case greater:
      return arg(0) > arg(1);
    case greater_equal:
      return arg(0) >= arg(1);
    case equal:
      return arg(0) == arg(1);
    case not_equal:
      return arg(0) != arg(1);
    case logical_and:
      return arg(0) != 0.0 && arg(1) != 0.0;
    case logical_or:
      return arg(0) != 0.0 || arg(1) != 0.0;
    case arc_tangent_2:
      return arc_tangent_2_of(arg(0), arg(1));
    case modulo:
      return modulo_of(arg(0), arg(1));
    case table:
      return table_of(*node.curve, arg(0));
    case smooth_step:
      return smooth_step_of(arg(0), arg(1), arg(2), arg(3), arg(4));
    case minimum:
    case maximum: {
      double least = arg(0);
      for (std::size_t i = 1; i < node.args.size(); ++i) {
        const double x = arg(i);
        if (node.code == minimum ? x < least : x > least) least = x;
      }
      return least;
    }
    default:
      return apply_unary(node.code, arg(0));
  }
}

bool compares(int code) {
  return code == less || code == less_equal || code == greater || code == greater_equal;
}

// Of min and max: by how much argument i is ahead of the next one, and which that is.
std::pair<double, int> lead_of(const FormulaTree& tree, int k, int i, const double* signals) {
  const FormulaNode& node = tree[k];
  const double own = value_at(tree, node.args[static_cast<std::size_t>(i)], signals);
  std::pair<double, int> least(std::numeric_limits<double>::infinity(), i);
  for (std::size_t j = 0; j < node.args.size(); ++j) {
    if (static_cast<int>(j) == i) continue;
    const double other = value_at(tree, node.args[j], signals);
    least = std::min(least, std::pair(node.code == minimum ? other - own : own - other, static_cast<int>(j)));
  }
  return least;
}

// What the condition looks at: it jumps where this passes 0 or, of what rounds, an edge between integers.
double looks_at(const FormulaTree& tree, int k, const double* signals) {
  const FormulaNode& node = tree[k];
  const double x = value_at(tree, node.args[0], signals);
  if (node.args.size() == 1) return x;
  const double y = value_at(tree, node.args[1], signals);
  if (node.code == modulo) return x / y;
  return node.code == less || node.code == less_equal ? y - x : x - y;
}

}  // namespace

bool Expression::is_kink(int condition) const {
  return bends_at(tree_[condition].code);
}

double Expression::switching(int condition, const double* signals) const {
  const FormulaNode& node = tree_[condition];
  if (signals[node.held] == 0.0) return 1.0;
  const int held = held_integer(static_cast<int>(signals[node.held]));
  if (is_extreme(node.code)) return lead_of(tree_, condition, held, signals).first;
  const double x = looks_at(tree_, condition, signals);
  if (compares(node.code) || node.code == absolute) return held != 0 ? x : -x;
  if (node.code == table) {
    const Interval piece = node.curve->between_kinks(x);
    const double now = node.curve->kinks_until(x);
    return now == held ? std::min(x - piece.lo, piece.hi - x) : now > held ? piece.lo - x : x - piece.hi;
  }
  if (node.code == signum) return held == 0 ? -std::abs(x) : held * x;
  const double lower = node.code == round_to_integer ? held - 0.5 : node.code == round_up ? held - 1.0 : held;
  return std::min(x - lower, lower + 1.0 - x);
}

int Expression::condition_now(int condition, const double* signals) const {
  const FormulaNode& node = tree_[condition];
  if (is_extreme(node.code)) {
    for (int i = 0; i + 1 < static_cast<int>(node.args.size()); ++i)
      if (lead_of(tree_, condition, i, signals).first >= 0.0) return held_signal(i);
    return held_signal(static_cast<int>(node.args.size()) - 1);
  }
  const double x = looks_at(tree_, condition, signals);
  double now = 0.0;
  if (node.code == absolute)
    now = x >= 0.0;
  else if (node.code == table)
    now = node.curve->kinks_until(x);
  else if (node.code == less || node.code == greater)
    now = x > 0.0;
  else if (compares(node.code))
    now = x >= 0.0;
  else
    now = node.code == modulo ? std::floor(x) : apply_unary(node.code, x);
  // Whole numbers too large for a signal are not held.
  return std::isfinite(now) && std::abs(now) < 2e9 ? held_signal(static_cast<int>(now)) : 0;
}

int Expression::condition_next(int condition, const double* signals) const {
  const FormulaNode& node = tree_[condition];
  const int held = held_integer(static_cast<int>(signals[node.held]));
  if (compares(node.code) || node.code == absolute) return held_signal(held != 0 ? 0 : 1);
  if (is_extreme(node.code)) return held_signal(lead_of(tree_, condition, held, signals).second);
  if (node.code == table) return condition_now(condition, signals);
  const double x = looks_at(tree_, condition, signals);
  if (node.code == signum) return held_signal(x > 0.0 ? 1 : x < 0.0 ? -1 : -held);
  const int now = condition_now(condition, signals);
  if (now == 0 || std::abs(held_integer(now) - held) > 1) return now;
  const double middle = node.code == round_to_integer ? held
                        : node.code == round_up       ? held - 0.5
                                                      : held + 0.5;
  return held_signal(x > middle ? held + 1 : held - 1);
}

}  // namespace flexura::mbs
