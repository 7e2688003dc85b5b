// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/controls/types.hpp"

namespace flexura::mbs {
namespace {

/// Pure delay by a time T, as Pade's approximation of exp(-s T) with n poles and n - 1 zeros, z = s T:
///
///     sum_k b_k (-z)^k / sum_k a_k z^k,   a_k = (2n - 1 - k)! n! / ((2n - 1)! k! (n - k)!)
///                                         b_k = (2n - 1 - k)! (n - 1)! / ((2n - 1)! k! (n - 1 - k)!)
///
/// in controllable form in the time t / T. It follows signals up to omega T of about n with an error below 1
/// %.
class Delay final : public Control {
 public:
  Delay(std::string name, std::shared_ptr<const Expression> in, double time, int order, double start)
      : Control(std::move(name)), input_(std::move(in)), time_(time), start_(start) {
    const auto factorial = [](int k) { return std::tgamma(k + 1.0); };
    const int n = order;
    for (int k = 0; k <= n; ++k)
      a_.push_back(factorial(2 * n - 1 - k) * factorial(n) /
                   (factorial(2 * n - 1) * factorial(k) * factorial(n - k)));
    for (int k = 0; k < n; ++k)
      b_.push_back((k % 2 ? -1.0 : 1.0) * factorial(2 * n - 1 - k) * factorial(n - 1) /
                   (factorial(2 * n - 1) * factorial(k) * factorial(n - 1 - k)));
  }
  std::string_view type() const override { return "delay"; }
  int n_states() const override { return static_cast<int>(b_.size()); }
  void start(double* c) const override {
    std::fill_n(c, n_states(), 0.0);
    c[0] = start_ / b_[0];
  }
  void rates(const double* signals, const double* c, double* c_rate) const override {
    const int n = n_states();
    double last = input_->evaluate(signals);
    for (int i = 0; i < n; ++i) last -= a_[i] * c[i];
    for (int i = 0; i + 1 < n; ++i) c_rate[i] = c[i + 1] / time_;
    c_rate[n - 1] = last / (a_[n] * time_);
  }
  double output(const double*, const double* c) const override {
    double y = 0.0;
    for (std::size_t i = 0; i < b_.size(); ++i) y += b_[i] * c[i];
    return y;
  }
  std::vector<int> reads() const override { return input_->reads(); }

 private:
  std::shared_ptr<const Expression> input_;
  double time_, start_;
  std::vector<double> a_, b_;
};

}  // namespace

ControlType delay_control() {
  using namespace input;
  ControlType type;
  type.name = "delay";
  type.doc = "A formula's value some time ago, by a Pade approximation with dynamic states.";
  type.keys = {expression("input", "what is delayed").required(),
               quantity("time", dim::time, "by how much").required().above(0.0),
               integer("order", "number of states; it follows angular frequencies up to about order / time")
                   .or_default("4")
                   .at_least(1)
                   .at_most(10),
               expression("start", "input before the start, a formula of parameters").or_default("0")};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Control> {
    return std::make_shared<Delay>(name, c.expression(s, "input"), s.quantity("time"), s.integer("order"),
                                   c.number(s, "start"));
  };
  return type;
}

}  // namespace flexura::mbs
