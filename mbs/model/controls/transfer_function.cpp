// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/controls/rational.hpp"
#include "mbs/model/controls/types.hpp"

namespace flexura::mbs {
namespace {

/// Y(s) / U(s) = (b_0 + b_1 s + ...) / (a_0 + a_1 s + ... + a_n s^n).
class TransferFunction final : public Rational {
 public:
  TransferFunction(std::string name, std::shared_ptr<const Expression> in, std::vector<double> b,
                   std::vector<double> a)
      : Rational(std::move(name), std::move(in), std::move(b), std::move(a), 1.0) {}
  std::string_view type() const override { return "transfer_function"; }
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
