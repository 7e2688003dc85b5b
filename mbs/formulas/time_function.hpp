// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "mbs/base/math/interval.hpp"
#include "mbs/formulas/expression.hpp"

/// A part of a formula that depends on time alone, directly or through inputs and measures: what it will do is
/// known before the run.  Asked about an interval of time, it says what its value and its first two derivatives
/// are within (interval arithmetic on its tree), and whether one of its branches (a comparison, abs, floor, a
/// kink of a table, ...) may change there.  So no jump and no pulse, however short, can be overlooked: an
/// interval is divided until it is proved to hold none.
namespace flexura::mbs {

class TimeFunction {
 public:
  struct Bounds {
    Interval value, first, second;
    bool is_decided = true;      ///< no branch changes within
    std::uint64_t branches = 0;  ///< which they are, where they are decided
  };
  struct Point {
    Jet jet;
    std::uint64_t branches = 0;
  };

  /// The tree of a measure or an input by its signal, nullptr where it is not a function of time.
  using Source = std::function<const FormulaTree*(int place)>;
  /// The part of `tree` at and below `node`.  `drives` where it is that of a motion, not of a force.
  TimeFunction(std::string where, bool drives, const FormulaTree& tree, int node, const Source& source);

  Bounds over(double begin, double end) const;
  Point at(double t) const;
  const std::string& where() const { return where_; }
  /// True where its derivatives are felt as jumps too: a drive.
  bool drives() const { return drives_; }
  /// The same for functions that are the same.
  std::string fingerprint() const;

  /// How large `tree` is with what it reads put in: nodes of measures that read one another multiply.
  static double size(const FormulaTree& tree, const Source& source);
  /// Nodes of `tree` that are functions of time, each as large as can be, without constants.
  static std::vector<int> parts(const FormulaTree& tree, const Source& source);

 private:
  int inline_tree(const FormulaTree& tree, int node, const Source& source);

  std::string where_;
  bool drives_;
  FormulaTree tree_;
};

}  // namespace flexura::mbs
