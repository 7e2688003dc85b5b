// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/time_function.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "mbs/formulas/interval_evaluation.hpp"
#include "mbs/formulas/operations.hpp"

namespace flexura::mbs {
namespace {

using namespace operations;
using operations::operator+, operations::operator-, operations::operator*, operations::operator/;

// At a moment.
class At {
 public:
  At(const FormulaTree& tree, double t) : tree_(tree), time_{t, 1.0, 0.0} {}
  Jet operator()(int k);
  Branches branches;

 private:
  Jet say(int k, bool truth) {
    branches.note(k, truth);
    return {truth ? 1.0 : 0.0, 0.0, 0.0};
  }
  const FormulaTree& tree_;
  Jet time_;
};

Jet At::operator()(int k) {
  const FormulaNode& node = tree_[k];
  if (node.code == choice) {
    const bool yes = (*this)(node.args[0]).value != 0.0;
    branches.note(k, yes);
    return (*this)(yes ? node.args[1] : node.args[2]);
  }
  if (node.code == logical_and || node.code == logical_or) {
    const bool enough = node.code == logical_or;
    const bool a = (*this)(node.args[0]).value != 0.0;
    const bool both = a == enough ? a : (*this)(node.args[1]).value != 0.0;
    return {both ? 1.0 : 0.0, 0.0, 0.0};
  }
  std::vector<Jet> x;
  x.reserve(node.args.size());
  for (const int arg : node.args) x.push_back((*this)(arg));
  switch (node.code) {
    case constant:
      return {node.value, 0.0, 0.0};
    case signal:
      return time_;
    case add:
      return x[0] + x[1];
    case subtract:
      return x[0] - x[1];
    case multiply:
      return x[0] * x[1];
    case divide:
      return x[0] / x[1];
    case power:
      return power_of(x[0], x[1]);
    case less:
      return say(k, x[0].value < x[1].value);
    case less_equal:
      return say(k, x[0].value <= x[1].value);
    case greater:
      return say(k, x[0].value > x[1].value);
    case greater_equal:
      return say(k, x[0].value >= x[1].value);
    case equal:
      return say(k, x[0].value == x[1].value);
    case not_equal:
      return say(k, x[0].value != x[1].value);
    case absolute:
    case signum:
      branches.note(k, apply_unary(signum, x[0].value));
      return apply_unary(node.code, x[0]);
    case round_to_integer:
    case round_down:
    case round_up:
      branches.note(k, apply_unary(node.code, x[0].value));
      return apply_unary(node.code, x[0]);
    case modulo:
      branches.note(k, std::floor(x[0].value / x[1].value));
      return modulo_of(x[0], x[1]);
    case minimum:
    case maximum: {
      std::size_t best = 0;
      for (std::size_t i = 1; i < x.size(); ++i)
        if (node.code == minimum ? x[i].value < x[best].value : x[i].value > x[best].value) best = i;
      branches.note(k, static_cast<double>(best));
      return x[best];
    }
    case smooth_step:
      branches.note(k, x[0].value <= x[1].value ? -1 : x[0].value >= x[3].value ? 1 : 0);
      return smooth_step_of(x[0], x[1], x[2], x[3], x[4]);
    case table:
      branches.note(k, node.curve->kinks_until(x[0].value));
      return table_of(*node.curve, x[0]);
    case arc_tangent_2:
      if (x[1].value < 0.0) branches.note(k, x[0].value >= 0.0 ? 1.0 : -1.0);
      return arc_tangent_2_of(x[0], x[1]);
    default:
      return apply_unary(node.code, x[0]);
  }
}

enum class Kind { constant, of_time, other };

Kind kind_of(const FormulaTree& tree, int k, const TimeFunction::Source& source) {
  const FormulaNode& node = tree[k];
  if (node.code == signal) {
    if (node.place == 0) return Kind::of_time;
    const FormulaTree* other = source(node.place);
    return other ? kind_of(*other, other->root, source) : Kind::other;
  }
  Kind kind = Kind::constant;
  for (const int arg : node.args) {
    const Kind of_arg = kind_of(tree, arg, source);
    if (of_arg == Kind::other) return of_arg;
    if (of_arg == Kind::of_time) kind = of_arg;
  }
  return kind;
}

}  // namespace

TimeFunction::TimeFunction(std::string where, bool drives, const FormulaTree& tree, int node,
                           const Source& source)
    : where_(std::move(where)), drives_(drives) {
  tree_.root = inline_tree(tree, node, source);
}

int TimeFunction::inline_tree(const FormulaTree& tree, int k, const Source& source) {
  FormulaNode node = tree[k];
  if (node.code == signal && node.place > 0) {
    const FormulaTree* other = source(node.place);
    return inline_tree(*other, other->root, source);
  }
  node.held = 0;
  for (int& arg : node.args) arg = inline_tree(tree, arg, source);
  return tree_.add(std::move(node));
}

TimeFunction::Point TimeFunction::at(double t) const {
  At at(tree_, t);
  const Jet jet = at(tree_.root);
  return {jet, at.branches.hash};
}

TimeFunction::Bounds TimeFunction::over(double begin, double end) const {
  const IntervalJet time{{begin, end}, 1.0, 0.0};
  IntervalEvaluation over(tree_, &time);
  const IntervalJet f = over(tree_.root);
  return {f.value, f.first, f.second, over.is_decided, over.branches.hash};
}

std::string TimeFunction::fingerprint() const {
  std::string text = drives_ ? "drive" : "force";
  for (const FormulaNode& node : tree_.nodes) {
    text += fmt::format(" {} {:a} {}", node.code, node.value, static_cast<const void*>(node.curve.get()));
    for (const int arg : node.args) text += fmt::format(",{}", arg);
  }
  return text;
}

double TimeFunction::size(const FormulaTree& tree, const Source& source) {
  std::map<const FormulaTree*, double> known;
  const auto measure = [&](const auto& self, const FormulaTree& one) -> double {
    if (const auto found = known.find(&one); found != known.end()) return found->second;
    double sum = 0.0;
    for (const FormulaNode& node : one.nodes) {
      const FormulaTree* other = node.code == signal && node.place > 0 ? source(node.place) : nullptr;
      sum += other ? self(self, *other) : 1.0;
    }
    return known[&one] = sum;
  };
  return measure(measure, tree);
}

std::vector<int> TimeFunction::parts(const FormulaTree& tree, const Source& source) {
  std::vector<int> found;
  const auto look = [&](const auto& self, int k) -> void {
    switch (kind_of(tree, k, source)) {
      case Kind::of_time:
        found.push_back(k);
        break;
      case Kind::other:
        for (const int arg : tree[k].args) self(self, arg);
        break;
      case Kind::constant:
        break;
    }
  };
  look(look, tree.root);
  return found;
}

}  // namespace flexura::mbs
