// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "mbs/controls/algebraic.hpp"
#include "mbs/controls/delay.hpp"
#include "mbs/controls/filter.hpp"
#include "mbs/controls/pid.hpp"
#include "mbs/controls/relay.hpp"
#include "mbs/controls/sample.hpp"
#include "mbs/controls/state.hpp"
#include "mbs/controls/transfer_function.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "mbs/file/elements/user_library.hpp"

/// Controls in a mechanism file.
namespace flexura::mbs {
namespace {

ControlType state() {
  ControlType type;
  type.name = "state";
  type.doc = "A state of the user's own: its rate by a formula that may read it and the others.";
  type.keys = {input::expression("rate", "time derivative of the state").required(),
               input::expression("start", "value at the start, a formula of parameters").or_default("0")};
  type.read = [](const std::string& name, const input::Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Control> {
    return std::make_shared<StateEquation>(name, c.expression(s, "rate"), c.number(s, "start"));
  };
  return type;
}

ControlType filter() {
  using namespace input;
  ControlType type;
  type.name = "filter";
  type.doc = "First-order lag of a formula.";
  type.keys = {
      expression("input", "what is filtered").required(),
      quantity("time_constant", dim::time, "time in which 63 % of a step are followed").required().above(0.0),
      expression("start", "output at the start, a formula of parameters").or_default("0")};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Control> {
    return std::make_shared<Filter>(name, c.expression(s, "input"), s.quantity("time_constant"),
                                    c.number(s, "start"));
  };
  return type;
}

ControlType pid() {
  using namespace input;
  ControlType type;
  type.name = "pid";
  type.doc =
      "Proportional-integral-derivative controller with filtered derivative, limits and anti-windup. The "
      "filter starts at an error of 0: an error of e at the start is a jump, which the derivative answers "
      "with "
      "derivative * e / filter_time at first. Let the target start where the joint stands, or give limits.";
  type.feeds_through = [](const input::Section&) { return true; };
  type.keys = {expression("error", "target minus measured value").required(),
               expression("proportional", "gain, output per error").or_default("0"),
               expression("integral", "gain, output per integral of the error").or_default("0"),
               expression("derivative", "gain, output per rate of the error").or_default("0"),
               quantity("filter_time", dim::time, "time constant of the derivative's filter")
                   .or_default("1 ms")
                   .above(0.0),
               expression("lower", "least output").or_default("-1e300"),
               expression("upper", "greatest output").or_default("1e300")};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Control> {
    Pid::Gains k;
    k.p = c.number(s, "proportional");
    k.i = c.number(s, "integral");
    k.d = c.number(s, "derivative");
    k.filter_time = s.quantity("filter_time");
    k.lower = c.number(s, "lower");
    k.upper = c.number(s, "upper");
    if (k.lower >= k.upper) s.refuse("lower", "is not below upper");
    return std::make_shared<Pid>(name, c.expression(s, "error"), k);
  };
  return type;
}

ControlType transfer_function() {
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

ControlType delay() {
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

ControlType relay() {
  using namespace input;
  ControlType type;
  type.name = "relay";
  type.doc = "A two-position switch with hysteresis, located by the integrator.";
  type.keys = {
      expression("input", "what it watches").required(),
      expression("on_above", "it goes on where the input rises above").or_default("0"),
      expression("off_below", "it goes off where the input falls below; without it as on_above"),
      expression("on", "output while on").or_default("1"),
      expression("off", "output while off").or_default("0"),
      flag("starts_on", "its position at the start where the input lies between").or_default("false")};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Control> {
    Relay::Levels levels;
    levels.on_above = c.number(s, "on_above");
    levels.off_below = s.has("off_below") ? c.number(s, "off_below") : levels.on_above;
    if (levels.off_below > levels.on_above) s.refuse("off_below", "is above on_above", "swap them");
    levels.on = c.number(s, "on");
    levels.off = c.number(s, "off");
    levels.starts_on = s.flag("starts_on");
    return std::make_shared<Relay>(name, c.expression(s, "input"), levels);
  };
  return type;
}

ControlType algebraic() {
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

ControlType sample() {
  using namespace input;
  ControlType type;
  type.name = "sample";
  type.doc = "Sample and hold: takes the input's value at fixed times and keeps it in between.";
  type.keys = {
      expression("input", "what it samples").required(),
      quantity("period", dim::time, "from sample to sample").required().above(0.0),
      quantity("first", dim::time, "time of the first sample; before it the output is 0").or_default("0 s")};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const Control> {
    return std::make_shared<Sample>(name, c.expression(s, "input"), s.quantity("period"),
                                    s.quantity("first"));
  };
  return type;
}

}  // namespace

const std::vector<ControlType>& control_types() {
  static const std::vector<ControlType> types = {state(), filter(),    pid(),    transfer_function(), delay(),
                                                 relay(), algebraic(), sample(), user_control()};
  return types;
}

}  // namespace flexura::mbs
