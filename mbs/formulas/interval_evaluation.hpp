// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "mbs/formulas/formula_tree.hpp"
#include "mbs/formulas/interval_jet.hpp"

/// A formula's tree on jets of intervals: what it and its first two derivatives by some parameter of a path are within,
/// where its signals are within the intervals given.
namespace flexura::mbs {

class IntervalEvaluation {
 public:
  /// `signals` by their places, with their derivatives along the path; both must outlive it.  Conditions that a signal
  /// holds are what they are held at.
  IntervalEvaluation(const FormulaTree& tree, const IntervalJet* signals) : tree_(tree), signals_(signals) {}

  /// Of the node k and what is below it.
  IntervalJet operator()(int k);

  bool is_decided = true;  ///< no branch changes within
  Branches branches;       ///< which they are

 private:
  enum class Truth { no, yes, open };
  static Truth positive(const Interval& x, double size);
  static Truth truth(const IntervalJet& x);
  static IntervalJet say(Truth truth);
  bool is_held(const FormulaNode& node) const;
  IntervalJet held(const FormulaNode& node, std::span<const IntervalJet> x) const;
  IntervalJet compare(int k, const IntervalJet& a, const IntervalJet& b);
  IntervalJet rounded(int k, const Interval& x);
  IntervalJet extreme(int k, std::span<const IntervalJet> x);
  IntervalJet step(int k, std::span<const IntervalJet> x);

  const FormulaTree& tree_;
  const IntervalJet* signals_;
};

}  // namespace flexura::mbs
