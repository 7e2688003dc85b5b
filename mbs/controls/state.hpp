// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/controls/control.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// x' = formula, which may read x itself and every other state: any system of first order. Its output is x.
class StateEquation final : public Control {
 public:
  StateEquation(std::string name, std::shared_ptr<const Expression> rate, double start)
      : Control(std::move(name)), rate_(std::move(rate)), start_(start) {}
  std::string_view type() const override { return "state"; }
  int n_states() const override { return 1; }
  void start(double* c) const override { c[0] = start_; }
  void rates(const double* signals, const double*, double* c_rate) const override {
    c_rate[0] = rate_->evaluate(signals);
  }
  double output(const double*, const double* c) const override { return c[0]; }
  void differentiate_rates(const double* signals, const double*, Derivatives& d) const override {
    d.rate(0);
    d.by_formula(*rate_, signals);
  }
  void differentiate(const double*, const double*, Derivatives& d) const override {
    d.rows();
    d.by_state(0, 1.0);
  }
  std::vector<int> reads() const override { return rate_->reads(); }

 private:
  std::shared_ptr<const Expression> rate_;
  double start_;
};

}  // namespace flexura::mbs
