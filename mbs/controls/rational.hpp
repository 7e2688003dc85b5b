// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/controls/control.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// A strictly proper rational function of z = s T applied to a formula u, from rest,
///
///     Y / U = (b_0 + b_1 z + ...) / (a_0 + a_1 z + ... + a_n z^n),
///
/// in controllable canonical form in the time t / T:
///
///     T x_i' = x_(i+1),   T x_n' = (u - a_0 x_1 - ... - a_(n-1) x_n) / a_n,   y = b_0 x_1 + b_1 x_2 + ...
class Rational : public Control {
 public:
  /// b: n coefficients at most; a: n + 1, the last not 0; T [s].
  Rational(std::string name, std::shared_ptr<const Expression> in, std::vector<double> b,
           std::vector<double> a, double T)
      : Control(std::move(name)), input_(std::move(in)), b_(std::move(b)), a_(std::move(a)), T_(T) {}
  int n_states() const override { return static_cast<int>(a_.size()) - 1; }
  void start(double* c) const override { std::fill_n(c, n_states(), 0.0); }
  void rates(const double* signals, const double* c, double* c_rate) const override {
    const int n = n_states();
    double last = input_->evaluate(signals);
    for (int i = 0; i < n; ++i) last -= a_[i] * c[i];
    for (int i = 0; i + 1 < n; ++i) c_rate[i] = c[i + 1] / T_;
    c_rate[n - 1] = last / (a_[n] * T_);
  }
  double output(const double*, const double* c) const override {
    double y = 0.0;
    for (std::size_t i = 0; i < b_.size(); ++i) y += b_[i] * c[i];
    return y;
  }
  void differentiate_rates(const double* signals, const double*, Derivatives& d) const override {
    const int n = n_states();
    for (int i = 0; i + 1 < n; ++i) {
      d.rate(i);
      d.by_state(i + 1, 1.0 / T_);
    }
    d.rate(n - 1);
    d.by_formula(*input_, signals, 1.0 / (a_[n] * T_));
    for (int i = 0; i < n; ++i) d.by_state(i, -a_[i] / (a_[n] * T_));
  }
  void differentiate(const double*, const double*, Derivatives& d) const override {
    d.rows();
    for (std::size_t i = 0; i < b_.size(); ++i) d.by_state(static_cast<int>(i), b_[i]);
  }
  std::vector<int> reads() const override { return input_->reads(); }
  int relative_degree() const override {
    int highest = static_cast<int>(b_.size()) - 1;
    while (highest > 0 && b_[static_cast<std::size_t>(highest)] == 0.0) --highest;
    return n_states() - highest;
  }

 protected:
  double b_0() const { return b_[0]; }

 private:
  std::shared_ptr<const Expression> input_;
  std::vector<double> b_, a_;
  double T_;
};

}  // namespace flexura::mbs
