// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/controls/control.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// A switch with two positions: on once its input rises above `on_above`, off once it falls below
/// `off_below`. Between the two it stays as it is. The integrator stops where it switches.
class Relay final : public Control {
 public:
  struct Levels {
    double on_above, off_below, on, off;
    bool starts_on;
  };
  Relay(std::string name, std::shared_ptr<const Expression> in, const Levels& levels)
      : Control(std::move(name)), input_(std::move(in)), levels_(levels) {}
  std::string_view type() const override { return "relay"; }
  int n_states() const override { return 1; }  // 1: on
  bool is_held(int) const override { return true; }
  void start(double* c) const override { c[0] = levels_.starts_on ? 1.0 : 0.0; }
  void rates(const double*, const double*, double* c_rate) const override { c_rate[0] = 0.0; }
  double output(const double*, const double* c) const override { return is_on(c) ? levels_.on : levels_.off; }
  /// Constant between switches.
  void differentiate(const double*, const double*, Derivatives&) const override {}
  std::vector<int> reads() const override { return input_->reads(); }

  int n_switches() const override { return 1; }
  std::string switch_name(int) const override { return "level"; }
  void switching(const double* signals, const double* c, double* values) const override {
    const double x = input_->evaluate(signals);
    values[0] = is_on(c) ? x - levels_.off_below : levels_.on_above - x;
  }
  void start_switches(const double* signals, double* c) const override {
    const double x = input_->evaluate(signals);
    if (x > levels_.on_above) c[0] = 1.0;
    if (x < levels_.off_below) c[0] = 0.0;
  }
  void change_switch(int, const double*, double* c) const override { c[0] = is_on(c) ? 0.0 : 1.0; }

 private:
  static bool is_on(const double* c) { return c[0] > 0.5; }
  std::shared_ptr<const Expression> input_;
  Levels levels_;
};

}  // namespace flexura::mbs
