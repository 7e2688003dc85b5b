// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/motion_function.hpp"

#include <algorithm>

#include "mbs/formulas/interval_evaluation.hpp"
#include "mbs/formulas/operations.hpp"

namespace flexura::mbs {

using namespace operations;

MotionFunction::MotionFunction(const Expression& formula)
    : where_(formula.where()), formula_(formula), tree_(formula.tree()) {
  list_places();
}

MotionFunction::MotionFunction(std::string where, std::shared_ptr<const Curve> curve, int place)
    : where_(std::move(where)) {
  FormulaNode argument, value;
  argument.code = signal;
  argument.place = place;
  value.code = table;
  value.args = {tree_.add(argument)};
  value.curve = std::move(curve);
  tree_.root = tree_.add(value);
  list_places();
}

void MotionFunction::list_places() {
  for (const FormulaNode& node : tree_.nodes) {
    if (node.code == signal) reads_.push_back(node.place);
    if (node.held > 0) reads_.push_back(node.held);
  }
  std::ranges::sort(reads_);
  reads_.erase(std::unique(reads_.begin(), reads_.end()), reads_.end());
}

double MotionFunction::at(const double* arguments) const {
  if (formula_) return formula_->evaluate_or_not_finite(arguments);
  const FormulaNode& curve = tree_[tree_.root];
  return (*curve.curve)(arguments[tree_[curve.args[0]].place]);
}

IntervalJet MotionFunction::over(const IntervalJet* arguments) const {
  return IntervalEvaluation(tree_, arguments)(tree_.root);
}

bool MotionFunction::may_peak(const FormulaTree& tree) {
  constexpr double kLowPower = 3.0;
  return tree.any(tree.root, [&](const FormulaNode& node) {
    switch (node.code) {
      case constant:
      case signal:
      case add:
      case subtract:
      case multiply:
      case plus:
      case minus:
        return false;
      case divide:
        return tree[node.args[1]].code != constant;
      case power: {
        const FormulaNode& n = tree[node.args[1]];
        return n.code != constant || !(n.value == 1.0 || n.value == 2.0 || n.value == kLowPower);
      }
      case sine:
      case cosine:
        return tree[node.args[0]].code != signal;
      default:
        return true;
    }
  });
}

}  // namespace flexura::mbs
