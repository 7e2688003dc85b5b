// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/controls/types.hpp"

namespace flexura::mbs {
namespace {

/// Y(s) / U(s) = (b_0 + b_1 s + ...) / (a_0 + a_1 s + ... + a_n s^n), strictly proper, in controllable
/// canonical form: x_i' = x_(i+1), x_n' = (u - a_0 x_1 - ... - a_(n-1) x_n) / a_n, y = b_0 x_1 + b_1 x_2 +
/// ...
class TransferFunction final : public Control {
 public:
  TransferFunction(std::string name, std::shared_ptr<const Expression> in, std::vector<double> b,
                   std::vector<double> a)
      : Control(std::move(name)), input_(std::move(in)), b_(std::move(b)), a_(std::move(a)) {}
  std::string_view type() const override { return "transfer_function"; }
  int n_states() const override { return static_cast<int>(a_.size()) - 1; }
  void start(double* c) const override {
    for (int i = 0; i < n_states(); ++i) c[i] = 0.0;
  }
  void rates(const double* signals, const double* c, double* c_rate) const override {
    const int n = n_states();
    double last = input_->evaluate(signals);
    for (int i = 0; i < n; ++i) last -= a_[i] * c[i];
    for (int i = 0; i + 1 < n; ++i) c_rate[i] = c[i + 1];
    c_rate[n - 1] = last / a_[n];
  }
  double output(const double*, const double* c) const override {
    double y = 0.0;
    for (std::size_t i = 0; i < b_.size(); ++i) y += b_[i] * c[i];
    return y;
  }
  std::vector<int> reads() const override { return input_->reads(); }

 private:
  std::shared_ptr<const Expression> input_;
  std::vector<double> b_, a_;
};

}  // namespace

ControlType transfer_function_control() {
  using namespace input;
  ControlType type;
  type.name = "transfer_function";
  type.doc = "A linear transfer function of a formula, starting from rest.";
  type.keys = {
      expression("input", "what goes in").required(),
      quantities("numerator", dim::none, "coefficients from s^0 upwards, SI").required(),
      quantities("denominator", dim::none, "coefficients from s^0 upwards, one more at least").required()};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Control> {
    std::vector<double> b = s.quantities("numerator"), a = s.quantities("denominator");
    if (a.size() < 2 || a.back() == 0.0)
      s.refuse("denominator", "does not end in a coefficient of s that is not 0");
    if (b.empty() || b.size() >= a.size())
      s.refuse("numerator", "must have fewer coefficients than the denominator", "split the direct part off");
    return std::make_shared<TransferFunction>(name, c.expression(s, "input"), std::move(b), std::move(a));
  };
  return type;
}

}  // namespace flexura::mbs
