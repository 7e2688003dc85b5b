// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mbs/formulas/expression.hpp"
#include "mbs/measures/measure.hpp"

namespace flexura::mbs {

/// A formula of signals.
class ExpressionMeasure final : public Measure {
 public:
  ExpressionMeasure(std::string name, std::shared_ptr<const Expression> value)
      : Measure(std::move(name)), value_(std::move(value)) {}
  input::Dimension dimension() const override { return input::dim::none; }
  double value(const Kinematics&, const double* signals) const override { return value_->evaluate(signals); }
  std::vector<int> reads() const override { return value_->reads(); }
  const Expression* formula() const override { return value_.get(); }
  void differentiate(const Kinematics&, const double* signals, Derivatives& d) const override {
    d.rows();
    d.by_formula(*value_, signals);
  }

 private:
  std::shared_ptr<const Expression> value_;
};

}  // namespace flexura::mbs
