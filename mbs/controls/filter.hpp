// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/controls/control.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// First-order lag: T y' + y = input.
class Filter final : public Control {
 public:
  Filter(std::string name, std::shared_ptr<const Expression> in, double time_constant, double start)
      : Control(std::move(name)), input_(std::move(in)), time_constant_(time_constant), start_(start) {}
  std::string_view type() const override { return "filter"; }
  int n_states() const override { return 1; }
  void start(double* c) const override { c[0] = start_; }
  void rates(const double* signals, const double* c, double* c_rate) const override {
    c_rate[0] = (input_->evaluate(signals) - c[0]) / time_constant_;
  }
  double output(const double*, const double* c) const override { return c[0]; }
  void differentiate_rates(const double* signals, const double*, Derivatives& d) const override {
    d.rate(0);
    d.by_formula(*input_, signals, 1.0 / time_constant_);
    d.by_state(0, -1.0 / time_constant_);
  }
  void differentiate(const double*, const double*, Derivatives& d) const override {
    d.rows();
    d.by_state(0, 1.0);
  }
  std::vector<int> reads() const override { return input_->reads(); }

 private:
  std::shared_ptr<const Expression> input_;
  double time_constant_, start_;
};

}  // namespace flexura::mbs
