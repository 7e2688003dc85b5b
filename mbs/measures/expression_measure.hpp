// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mbs/formulas/expression.hpp"
#include "mbs/measures/measure.hpp"

namespace flexura::mbs {

/// A formula of signals, in SI; what it is a quantity of is the user's to say.
class ExpressionMeasure final : public Measure {
 public:
  ExpressionMeasure(std::string name, std::shared_ptr<const Expression> value,
                    input::Dimension dimension = input::dim::none)
      : Measure(std::move(name)), value_(std::move(value)), dimension_(dimension) {}
  input::Dimension dimension() const override { return dimension_; }
  double value(const Kinematics&, const double* signals) const override { return value_->evaluate(signals); }
  std::vector<int> reads() const override { return value_->reads(); }
  const Expression* formula() const override { return value_.get(); }
  void differentiate(const Kinematics&, const double* signals, Derivatives& d) const override {
    d.rows();
    d.by_formula(*value_, signals);
  }

 private:
  std::shared_ptr<const Expression> value_;
  input::Dimension dimension_;
};

}  // namespace flexura::mbs
