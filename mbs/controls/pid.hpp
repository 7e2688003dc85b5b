// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "mbs/controls/control.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// Output K_p e + K_i i + K_d (e - f) / T_f, with the states i' = e and, where K_d is not 0, the lagged error
/// f' = (e - f) / T_f; held within limits, where the integral stops (anti-windup).
class Pid final : public Control {
 public:
  struct Gains {
    double p, i, d, filter_time, lower, upper;
  };
  Pid(std::string name, std::shared_ptr<const Expression> error, const Gains& gains)
      : Control(std::move(name)), error_(std::move(error)), k_(gains) {}
  std::string_view type() const override { return "pid"; }
  int n_states() const override { return 2; }
  void start(double* c) const override { c[0] = c[1] = 0.0; }
  void rates(const double* signals, const double* c, double* c_rate) const override {
    const double e = error_->evaluate(signals);
    c_rate[0] = winds_up(e, c) ? 0.0 : e;
    c_rate[1] = (e - c[1]) / k_.filter_time;
  }
  double output(const double* signals, const double* c) const override {
    return std::clamp(unlimited(error_->evaluate(signals), c), k_.lower, k_.upper);
  }
  void differentiate_rates(const double* signals, const double* c, Derivatives& d) const override {
    const double e = error_->evaluate(signals);
    if (!winds_up(e, c)) {
      d.rate(0);
      d.by_formula(*error_, signals);
    }
    d.rate(1);
    d.by_formula(*error_, signals, 1.0 / k_.filter_time);
    d.by_state(1, -1.0 / k_.filter_time);
  }
  void differentiate(const double* signals, const double* c, Derivatives& d) const override {
    const double u = unlimited(error_->evaluate(signals), c);
    if (u < k_.lower || u > k_.upper) return;
    d.rows();
    d.by_formula(*error_, signals, k_.p + k_.d / k_.filter_time);
    d.by_state(0, k_.i);
    d.by_state(1, -k_.d / k_.filter_time);
  }
  bool feeds_through() const override { return true; }
  std::vector<int> reads() const override { return error_->reads(); }

 private:
  bool winds_up(double e, const double* c) const {
    const double u = unlimited(e, c);
    return (u > k_.upper && k_.i * e > 0.0) || (u < k_.lower && k_.i * e < 0.0);
  }
  double unlimited(double e, const double* c) const {
    return k_.p * e + k_.i * c[0] + k_.d * (e - c[1]) / k_.filter_time;
  }
  std::shared_ptr<const Expression> error_;
  Gains k_;
};

}  // namespace flexura::mbs
