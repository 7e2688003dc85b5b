// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/controls/control.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// A signal a that solves 0 = equation(a, other signals): an implicit loop. The equation must depend on a.
class AlgebraicLoop final : public Control {
 public:
  AlgebraicLoop(std::string name, std::shared_ptr<const Expression> equation, double guess)
      : Control(std::move(name)), equation_(std::move(equation)), guess_(guess) {}
  std::string_view type() const override { return "algebraic"; }
  int n_states() const override { return 0; }
  void start(double*) const override {}
  void rates(const double*, const double*, double*) const override {}
  double output(const double*, const double*) const override { return guess_; }
  void differentiate(const double* signals, const double*, Derivatives& d) const override {
    d.rows();
    d.by_formula(*equation_, signals);
  }
  std::vector<int> reads() const override { return equation_->reads(); }
  bool is_algebraic() const override { return true; }
  double start_algebraic() const override { return guess_; }
  double residual(const double* signals) const override { return equation_->evaluate(signals); }
  const Expression* equation() const override { return equation_.get(); }

 private:
  std::shared_ptr<const Expression> equation_;
  double guess_;
};

}  // namespace flexura::mbs
