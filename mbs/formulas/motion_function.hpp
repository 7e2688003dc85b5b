// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mbs/formulas/expression.hpp"
#include "mbs/formulas/interval_jet.hpp"

/// A formula or a curve that reads the motion: what it will do is not known before the run, but what it does between the
/// points that a step has looked at is, once the step is done.  Along the step its arguments are polynomials of the time;
/// asked about a part of it, the function says what it is within.
namespace flexura::mbs {

class MotionFunction {
 public:
  explicit MotionFunction(const Expression& formula);
  /// The curve of the argument in one place.
  MotionFunction(std::string where, std::shared_ptr<const Curve> curve, int place);

  const std::string& where() const { return where_; }
  /// Places of the arguments, the time and what holds conditions among them.
  const std::vector<int>& reads() const { return reads_; }
  /// Of arguments by their places; not finite where it has no value.
  double at(const double* arguments) const;
  /// Where the arguments are within these, by their places.
  IntervalJet over(const IntervalJet* arguments) const;

  /// False of a formula that no step leaps over: sums, products and low powers of what it reads, sines and cosines of
  /// a signal itself.
  static bool may_peak(const FormulaTree& tree);

 private:
  void list_places();

  std::string where_;
  std::optional<Expression> formula_;  // nothing: a curve
  FormulaTree tree_;
  std::vector<int> reads_;
};

}  // namespace flexura::mbs
