// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/controls/rational.hpp"
#include "mbs/model/controls/types.hpp"

namespace flexura::mbs {
namespace {

/// Pure delay by a time T, as Pade's approximation of exp(-s T) with n poles and n - 1 zeros, z = s T:
///
///     sum_k b_k (-z)^k / sum_k a_k z^k,   a_k = (2n - 1 - k)! n! / ((2n - 1)! k! (n - k)!)
///                                         b_k = (2n - 1 - k)! (n - 1)! / ((2n - 1)! k! (n - 1 - k)!)
///
/// It follows signals up to omega T of about n with an error below 1 %.
class Delay final : public Rational {
 public:
  Delay(std::string name, std::shared_ptr<const Expression> in, double T, int order, double start)
      : Rational(std::move(name), std::move(in), numerator(order), denominator(order), T), start_(start) {}
  std::string_view type() const override { return "delay"; }
  /// As if the input had been `start` for ever.
  void start(double* c) const override {
    Rational::start(c);
    c[0] = start_ / b_0();
  }

 private:
  static double factorial(int k) { return std::tgamma(k + 1.0); }
  static std::vector<double> numerator(int n) {
    std::vector<double> b;
    for (int k = 0; k < n; ++k)
      b.push_back((k % 2 ? -1.0 : 1.0) * factorial(2 * n - 1 - k) * factorial(n - 1) /
                  (factorial(2 * n - 1) * factorial(k) * factorial(n - 1 - k)));
    return b;
  }
  static std::vector<double> denominator(int n) {
    std::vector<double> a;
    for (int k = 0; k <= n; ++k)
      a.push_back(factorial(2 * n - 1 - k) * factorial(n) /
                  (factorial(2 * n - 1) * factorial(k) * factorial(n - k)));
    return a;
  }
  double start_;
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
