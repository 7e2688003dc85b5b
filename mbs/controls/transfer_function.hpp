// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/controls/control.hpp"
#include "mbs/controls/rational.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// Y(s) / U(s) = (b_0 + b_1 s + ...) / (a_0 + a_1 s + ... + a_n s^n).
class TransferFunction final : public Rational {
 public:
  TransferFunction(std::string name, std::shared_ptr<const Expression> in, std::vector<double> b,
                   std::vector<double> a)
      : Rational(std::move(name), std::move(in), std::move(b), std::move(a), 1.0) {}
  std::string_view type() const override { return "transfer_function"; }
};

}  // namespace flexura::mbs
