// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "mbs/controls/control.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// Sample and hold, as a digital controller sees the world: every `period` the output takes the input's value
/// and keeps it.  c = (value, time of the next sample), both constant between samples, at which the
/// integrator stops.
class Sample : public Control {
 public:
  Sample(std::string name, std::shared_ptr<const Expression> in, double period, double start)
      : Control(std::move(name)), input_(std::move(in)), period_(period), start_(start) {}
  std::string_view type() const override { return "sample"; }
  int n_states() const override { return 2; }
  bool is_held(int) const override { return true; }
  void start(double* c) const override {
    c[0] = 0.0;
    c[1] = start_;
  }
  void rates(const double*, const double*, double* c_rate) const override { c_rate[0] = c_rate[1] = 0.0; }
  double output(const double*, const double* c) const override { return c[0]; }
  void differentiate(const double*, const double*, Derivatives& d) const override {
    d.rows();
    d.by_state(0, 1.0);
  }
  std::vector<int> reads() const override { return input_->reads(); }
  std::shared_ptr<const Control> on_the_average() const override;

  int n_switches() const override { return 1; }
  std::string switch_name(int) const override { return "sample"; }
  void switching(const double* signals, const double* c, double* values) const override {
    values[0] = c[1] - signals[0];
  }
  void start_switches(const double* signals, double* c) const override {
    if (signals[0] < c[1]) return;
    c[0] = input_->evaluate(signals);
    c[1] = at(std::floor((signals[0] - start_) / period_ + 1e-9) + 1.0);
  }
  void change_switch(int, const double* signals, double* c) const override {
    c[0] = input_->evaluate(signals);
    c[1] = at(std::rint((c[1] - start_) / period_) + 1.0);
  }

 protected:
  const Expression& input() const { return *input_; }
  double period() const { return period_; }  ///< [s]

 private:
  /// Times of samples do not add up the round-off of those before.
  double at(double number) const { return start_ + number * period_; }

  std::shared_ptr<const Expression> input_;
  double period_, start_;
};

/// What is held for a period T is on the average T / 2 old (K. J. Astrom, B. Wittenmark, Computer-Controlled Systems, 3rd
/// ed. 1997): a lag of that time.
class SampleAsLag final : public Sample {
 public:
  explicit SampleAsLag(const Sample& sample) : Sample(sample) {}
  bool is_held(int state) const override { return state == 1; }
  void rates(const double* signals, const double* c, double* c_rate) const override {
    c_rate[0] = (input().evaluate(signals) - c[0]) / (0.5 * period());
    c_rate[1] = 0.0;
  }
  void differentiate_rates(const double* signals, const double*, Derivatives& d) const override {
    d.rate(0);
    d.by_formula(input(), signals, 2.0 / period());
    d.by_state(0, -2.0 / period());
  }
};

inline std::shared_ptr<const Control> Sample::on_the_average() const {
  return std::make_shared<SampleAsLag>(*this);
}

}  // namespace flexura::mbs
