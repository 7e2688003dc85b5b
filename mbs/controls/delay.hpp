// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/controls/control.hpp"
#include "mbs/controls/rational.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

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

}  // namespace flexura::mbs
