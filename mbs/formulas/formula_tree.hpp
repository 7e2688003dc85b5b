// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "mbs/formulas/curve.hpp"

/// A formula as a tree of operations, for what its program cannot say: what it is made of, where it jumps,
/// which of its parts depend on time alone.
namespace flexura::mbs {

struct FormulaNode {
  int code = 0;           ///< operations::Code; `choice` has the arguments condition, yes, no
  std::vector<int> args;  ///< places in FormulaTree::nodes
  double value = 0.0;     ///< of a constant
  int place = 0;          ///< of a signal: 0 is t
  std::shared_ptr<const Curve> curve;
  int held = 0;  ///< signal that says what this condition is held at, 0 where it is always as it is
};

struct FormulaTree {
  std::vector<FormulaNode> nodes;
  int root = -1;

  const FormulaNode& operator[](int i) const { return nodes[static_cast<std::size_t>(i)]; }
  int add(FormulaNode node) {
    nodes.push_back(std::move(node));
    return static_cast<int>(nodes.size()) - 1;
  }
  /// Whether anything at or below `node` satisfies f(const FormulaNode&).
  bool any(int node, const std::function<bool(const FormulaNode&)>& f) const {
    if (f((*this)[node])) return true;
    for (const int arg : (*this)[node].args)
      if (any(arg, f)) return true;
    return false;
  }
};

/// Conditions that jump: comparisons, sign and what rounds.  A formula of the motion holds them between
/// events, as integers: 0 and 1 of a comparison, the sign, the whole number.  A signal keeps such an integer
/// so that 0 is left over for "not held".
inline int held_signal(int integer) {
  return integer >= 0 ? integer + 1 : integer;
}
inline int held_integer(int signal) {
  return signal > 0 ? signal - 1 : signal;
}

}  // namespace flexura::mbs
