// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "mbs/equations/equations.hpp"

/// What an integrator remembers of its past, as plain numbers: with it a continued run repeats the unbroken
/// one to the bit.  An integrator names its members once, in a function that both directions call.
namespace flexura::mbs {

class History {
 public:
  History() = default;
  explicit History(std::vector<double> values) : values_(std::move(values)), reads_(true) {}

  const std::vector<double>& values() const { return values_; }

  template <class T>
  void operator()(T& x) {
    if constexpr (std::is_arithmetic_v<T>) {
      if (reads_)
        x = next_as<T>();
      else
        values_.push_back(static_cast<double>(x));
    } else {
      long n = static_cast<long>(x.size());
      (*this)(n);
      if (reads_) {
        if (n < 0 || n > static_cast<long>(values_.size() - at_)) refuse();
        x.resize(n);
      }
      for (long i = 0; i < n; ++i) (*this)(x[i]);
    }
  }
  void operator()(State& s) {
    (*this)(s.t);
    for (Eigen::VectorXd* x : {&s.p, &s.v, &s.c, &s.lambda, &s.a}) (*this)(*x);
    (*this)(s.root);
    (*this)(s.hysteresis);
  }
  void all(double* x, long n) {
    for (long i = 0; i < n; ++i) (*this)(x[i]);
  }
  bool reads() const { return reads_; }
  bool is_used_up() const { return at_ == values_.size(); }

 private:
  // What was changed by hand may be any number.
  template <class T>
  T next_as() {
    const double value = next();
    if constexpr (std::is_integral_v<T>) {
      constexpr double largest = 9007199254740992.0;  // 2^53: beyond, doubles are no counts
      if (!(std::abs(value) <= largest) || !(value >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
                                             value <= static_cast<double>(std::numeric_limits<T>::max())))
        refuse();
    }
    return static_cast<T>(value);
  }
  double next() {
    if (at_ >= values_.size()) refuse();
    return values_[at_++];
  }
  [[noreturn]] static void refuse() {
    throw std::invalid_argument(
        "the integrator's history does not fit this mechanism: it was saved by another one, or is cut short; "
        "start from the states alone (--from-state)");
  }
  std::vector<double> values_;
  std::size_t at_ = 0;
  bool reads_ = false;
};

}  // namespace flexura::mbs
