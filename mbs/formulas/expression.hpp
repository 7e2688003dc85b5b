// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "mbs/formulas/curve.hpp"
#include "mbs/formulas/formula_tree.hpp"

/// Formulas of time, parameters and measured quantities.
///
/// The text (formula_parser.hpp) becomes a tree and, once, a small program that is constant, allocates
/// nothing and runs on plain numbers or on jets (value, d/dt, d^2/dt^2), so that a drive's velocity and
/// acceleration are exact and not differences.  Known are + - * / ^, comparisons, && || and ? :, the
/// constants pi and e, and sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp ln log log10
/// log2 sqrt abs sign rint floor ceil min max pow(x, y), mod(x, y) (what is left of x after whole multiples
/// of y, of the sign of y) and step(x, x0, y0, x1, y1): the cubic from y0 at x0 to y1 at x1, level outside.
/// A table of the file is a function of one argument by its name.
///
/// A comparison, sign(), rint(), floor(), ceil() and mod() of states is a *condition* of the motion: between
/// events it is held at what it was, so that forces are smooth there, and its switching function says when
/// that ends (Mechanism::roots).  What it is held at comes with the signals.  Likewise abs(), min() and max() and the
/// kinks of a table, which are no jumps: that these are conditions is for no step to leap over a short bump.
namespace flexura::mbs {

/// A value with its first two time derivatives.
struct Jet {
  double value = 0.0, first = 0.0, second = 0.0;
};

/// Names that formulas may use, each with its place in the array of values.  Place 0 is the time t.
class SignalNames {
 public:
  SignalNames() { add("t"); }
  int add(const std::string& name);         ///< the place of the name, new or known
  int find(const std::string& name) const;  ///< -1 when unknown
  const std::vector<std::string>& names() const { return names_; }
  /// The same places under the names that a subsystem uses for its own: without `prefix`; others have no
  /// name.
  SignalNames within(const std::string& prefix) const;
  int size() const { return static_cast<int>(names_.size()); }
  /// A place that no formula can name.
  int add_hidden() {
    names_.emplace_back();
    return size() - 1;
  }

 private:
  std::vector<std::string> names_;
  std::map<std::string, int> place_;
};

class Expression {
 public:
  /// Throws std::invalid_argument: syntax, an unknown name ("did you mean ...?"), an assignment.
  /// `where` names the element in this and in later messages; `constants` are the parameters.  Conditions on
  /// signals get hidden places in `held`, where there is one, else they are always as they are.
  Expression(std::string where, std::string text, const SignalNames& signals,
             const std::map<std::string, double>& constants, const Curves& tables = {},
             SignalNames* held = nullptr);

  const std::string& text() const { return text_; }
  const std::string& where() const { return where_; }
  /// Places of the signals the formula reads, without t.
  const std::vector<int>& reads() const { return reads_; }
  bool reads_time() const { return reads_time_; }

  /// Throws std::runtime_error, naming the element and the time, when the result is not finite.
  double evaluate(const double* signals) const;
  /// The same; a result that is not finite is given back.
  double evaluate_or_not_finite(const double* signals) const;

  /// Its derivative by the signal in one place.
  double derivative(const double* signals, int place) const;
  /// f, f', f'' of a formula of t and parameters alone.
  Jet time_derivatives(double t) const;
  /// f, f', f'' where the signals go as `jets` (by their places; read are t and reads()); `signals` holds conditions.
  Jet along(const double* signals, const Jet* jets) const;

  const FormulaTree& tree() const { return tree_; }
  /// Nodes of the tree that are conditions with a place to hold them.
  const std::vector<int>& conditions() const { return conditions_; }
  /// The formula bends there but does not jump.
  bool is_kink(int condition) const;
  /// Positive while the condition is what it is held at, from the other conditions as they are held.
  double switching(int condition, const double* signals) const;
  /// What the condition is now, and what it becomes where its switching function fell below 0, as signals
  /// keep it (held_signal).
  int condition_now(int condition, const double* signals) const;
  int condition_next(int condition, const double* signals) const;

 private:
  struct Instruction {
    int code;          ///< of operations.hpp
    int count = 0;     ///< arguments of a function, or target of a jump
    int place = 0;     ///< of a signal; of a condition, where it is held
    double value = 0;  ///< of a constant
  };
  template <class T>
  T run(const double* signals, const T& time, int moving = 0, const Jet* jets = nullptr) const;
  [[noreturn]] void refuse_value(double value, double t) const;
  std::size_t compile(int node, std::size_t top, std::vector<int>& node_of);
  void find_conditions(SignalNames& held, const std::vector<int>& node_of);

  std::string where_, text_;
  std::vector<Instruction> program_;
  std::vector<std::shared_ptr<const Curve>> tables_;
  std::vector<int> reads_;
  bool reads_time_ = false;
  FormulaTree tree_;
  std::vector<int> conditions_;
};

}  // namespace flexura::mbs
