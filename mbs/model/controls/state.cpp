// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/controls/types.hpp"

namespace flexura::mbs {
namespace {

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

}  // namespace

ControlType state_control() {
  ControlType type;
  type.name = "state";
  type.doc = "A state of the user's own: its rate by a formula that may read it and the others.";
  type.keys = {input::expression("rate", "time derivative of the state").required(),
               input::expression("start", "value at the start, a formula of parameters").or_default("0")};
  type.read = [](const std::string& name, const input::Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Control> {
    return std::make_shared<StateEquation>(name, c.expression(s, "rate"), c.number(s, "start"));
  };
  return type;
}

}  // namespace flexura::mbs
