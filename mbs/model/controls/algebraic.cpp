// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/controls/types.hpp"

namespace flexura::mbs {
namespace {

/// A signal a that solves 0 = equation(a, other signals): an implicit loop. The equation must depend on a.
class AlgebraicLoop final : public Control {
 public:
  AlgebraicLoop(std::string name, std::shared_ptr<const Expression> equation, double guess)
      : Control(std::move(name)), equation_(std::move(equation)), guess_(guess) {}
  std::string_view type() const override { return "algebraic"; }
  int n_states() const override { return 0; }
  void start(double*) const override {}
  void rates(const double*, const double*, double*) const override {}
  double output(const double*, const double*) const override { return guess_; }
  void differentiate(const double* signals, const double*, Derivatives& d) const override {
    d.rows();
    d.by_formula(*equation_, signals);
  }
  std::vector<int> reads() const override { return equation_->reads(); }
  bool is_algebraic() const override { return true; }
  double start_algebraic() const override { return guess_; }
  double residual(const double* signals) const override { return equation_->evaluate(signals); }

 private:
  std::shared_ptr<const Expression> equation_;
  double guess_;
};

}  // namespace

ControlType algebraic_control() {
  using namespace input;
  ControlType type;
  type.name = "algebraic";
  type.doc = "A signal that solves an equation with itself in it: an algebraic state.";
  type.keys = {
      expression("equation", "what must vanish, a formula with this control's own name in it").required(),
      expression("guess", "where the solution is sought at the start").or_default("0")};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Control> {
    auto equation = c.expression(s, "equation");
    const int own = c.description().signals.find(name);
    if (std::ranges::find(equation->reads(), own) == equation->reads().end())
      s.refuse("equation", "does not depend on " + name, "write the unknown into it by its name");
    return std::make_shared<AlgebraicLoop>(name, std::move(equation), c.number(s, "guess"));
  };
  return type;
}

}  // namespace flexura::mbs
