// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>

#include "tests/mbs/cases/text_case.hpp"

/// What jumps, kinks or pulses at times that are known before the run, and what conditions on the motion do,
/// against closed solutions.  A mass of 1 kg on a slider: its speed is the impulse that it got.
namespace flexura::mbs::cases {
namespace {

const std::string slider = R"toml(
gravity = [0, 0, 0]
[parameters]
at = 6.5
width = 0.002
size = 100
[table.bump]
x = [0, 3, 3.0000001, 3.01, 3.0100001, 10]
y = [0, 0, 10, 10, 0, 0]
interpolation = "linear"
[ground.marker.g]
axis = [0, 0, 1]
[body.m]
mass = 1
inertia = [1, 1, 1]
[body.m.marker.s]
axis = [0, 0, 1]
[joint.s]
type = "prismatic"
from = "ground.g"
to = "m.s"
)toml";

std::string pushed_by(const std::string& formula) {
  return slider + "[force.f]\ntype = \"force\"\nmarker = \"m.s\"\nz = \"" + formula + "\"\n";
}

/// "radau", or with a fixed step "runge_kutta 0.07".
struct Method {
  std::string name, fixed_step;
  std::string solver(const std::string& end_time = "10", const std::string& output_step = "1") const {
    std::string text = fmt::format("[solver]\nend_time = {}\noutput_step = {}\nmethod = \"{}\"\n", end_time,
                                   output_step, name);
    return fixed_step.empty() ? text : text + "fixed_step = " + fixed_step + "\n";
  }
};

const Method methods[] = {{"ida", ""},
                          {"radau", ""},
                          {"runge_kutta", ""},
                          {"generalised_alpha", ""},
                          {"runge_kutta", "0.07"},
                          {"generalised_alpha", "0.07"}};

std::string name_of(const ::testing::TestParamInfo<Method>& info) {
  return info.param.name + (info.param.fixed_step.empty() ? "" : "_fixed");
}

class TimeEvents : public TextCase, public ::testing::WithParamInterface<Method> {
 protected:
  Series simulated(const std::string& text, const std::vector<std::string>& names) const {
    return simulate(prepared(text), names);
  }
};

struct Push {
  std::string formula;
  double impulse, error;
};

TEST_P(TimeEvents, AnImpulseIsWhole) {
  const double round_off = 1e-9;  // of steps that follow polynomials exactly
  const Push pushes[] = {
      {"t>0.5 && t<0.51 ? 1000 : 0", 10.0, round_off},
      {"(t>=at)*(t<=at+width)*size", 0.2, round_off},
      {"t > 2 ? t < 2.001 ? 500 : t < 5 ? 0 : t < 5.001 ? -200 : 0 : 0", 0.3, round_off},
      {"!(t > 1 || t < 0.999)", 0.001, round_off},
      // Two ends, each known to the resolution of t.
      {"t > 7 ? (t < 7+1e-9 ? 1e9 : 0) : 0", 1.0, 2.0 * 8.9e-16 / 1e-9},
      {"t < 1e-9 ? 1e9 : 0", 1.0, 1e-8},
      {"floor(t/2) == 3 ? 1 : 0", 2.0, round_off},
      {"ceil(t) == 9", 1.0, round_off},
      {"rint(t) == 4", 1.0, round_off},
      {"mod(t, 2.5) < 0.001 ? 100 : 0", 0.4, round_off},
      {"(t>3)*(t<3.1)*(1 + sign(sin(2*pi*50*(t-3))))/2", 0.05, round_off},
      {"1e4*max(0, 1 - abs(t - 5)/1e-4)", 1.0, 1e-8},
      {"step(t,4,0,4.0001,1e4) - step(t,4.0002,0,4.0003,1e4)", 2.0, 1e-5},
      {"bump(t)", 0.1, round_off},
      {"abs(t-5) < 1e-5 ? 1000*cos((t-5)*pi/2e-5)^2 : 0", 0.01, 1e-6},
      {"1000*exp(-((t-5)/0.001)^2)", std::sqrt(M_PI), 1e-4},
      {"1e6*exp(-((t-5)/1e-6)^2)", std::sqrt(M_PI), 1e-4},
      {"1000/(1 + ((t-5)/0.001)^2)", std::atan(5000.0) * 2.0, 1e-3},
      // So short that parts of it were worth nothing each, and all of it was leapt over.
      {"1e7/cosh((t-5)/1e-7)^2", 2.0, 5e-4},
      {"1e9*exp(-((t-5)/1e-9)^2)", std::sqrt(M_PI), 1e-4},
      {"1e6/(1+exp((5-t)/1e-8)) - 1e6/(1+exp((5.000001-t)/1e-8))", 1.0, 1e-4},
      {"t > 0.5 && t < 0.51 ? 1000*(2 + tanh(0*s.speed))/2 : 0", 10.0, round_off},
  };
  for (const Push& push : pushes) {
    // !x is not in the language of formulas.
    if (push.formula[0] == '!') continue;
    const Series s = simulated(pushed_by(push.formula) + GetParam().solver(), {"s.speed"});
    // A method of order two follows what bends less exactly, with fixed steps by some percent.
    const bool bends = GetParam().name == "generalised_alpha" && push.error >= 1e-8;
    const bool is_fixed = !GetParam().fixed_step.empty();
    const double looser = !bends ? 1.0 : is_fixed ? 0.05 / push.error : 100.0;
    EXPECT_NEAR(s.values.back()(0), push.impulse, push.error * looser * (1.0 + push.impulse)) << push.formula;
    if (!bends || !is_fixed)
      EXPECT_LT(std::abs(s.result.energy.error()), 1e-3 * s.result.energy.work_in + 1e-12) << push.formula;
  }
}

TEST_P(TimeEvents, ComeThroughInputsMeasuresAndControls) {
  const std::string pulse = "t > 6 && t < 6.0001 ? 1e4 : 0";
  const std::string sources[] = {
      "[input.u]\nvalue = \"" + pulse + "\"\n",
      "[measure.u]\ntype = \"expression\"\nvalue = \"" + pulse + "\"\n",
      "[input.v]\nvalue = \"t - 6\"\n[measure.u]\ntype = \"expression\"\n"
      "value = \"v > 0 && v < 0.0001 ? 1e4 : 0\"\n",
      "[input.v]\nvalue = \"" + pulse +
          "\"\n[control.u]\ntype = \"relay\"\ninput = \"v\"\non_above = 5\non = 1e4\n",
      // Two samples hold the pulse, one at 6.00005 s.
      "[input.v]\nvalue = \"" + pulse +
          "\"\n[control.u]\ntype = \"sample\"\ninput = \"v\"\nperiod = \"0.1 ms\"\nfirst = \"5.99995 s\"\n",
      "[control.i]\ntype = \"state\"\nrate = \"" + pulse +
          "\"\n[measure.u]\ntype = \"expression\"\n"
          "value = \"i > 0.5 && t < 6.0001 ? 2e4 : 0\"\n",
  };
  for (const std::string& source : sources) {
    std::string text = pushed_by("u") + source + GetParam().solver();
    if (source.find("sample") != std::string::npos) text += "stop_time = 6.001\n";
    const PreparedMechanism p = prepared(text);
    RunResult r = run(*p.mechanism, p.state, p.v_dot, p.options);
    EXPECT_NEAR(r.state.v(0), 1.0, 2e-9) << source << r.stopped_because;
  }
}

TEST_P(TimeEvents, RowsThereShowWhatWasBefore) {
  for (const std::string formula : {"t > 0.5 ? 1 : 0", "t >= 0.5 ? 1 : 0", "t < 0.5 ? 0 : 1"}) {
    const Series s = simulated(pushed_by(formula) + GetParam().solver("1", "0.125"), {"f.z", "s.speed"});
    ASSERT_EQ(s.values.size(), 9u);
    EXPECT_EQ(s.values[4](0), 0.0) << formula;
    EXPECT_EQ(s.values[5](0), 1.0) << formula;
    EXPECT_NEAR(s.values.back()(1), 0.5, 1e-9) << formula;
  }
}

TEST_P(TimeEvents, AContinuedRunIsTheSameToTheBit) {
  const std::string text =
      pushed_by(
          "(t>0.5)*(t<0.51)*1000 - 3*sin(20*t) - 40*s.position - (s.position > 0.4 ? 2 : 1) + "
          "1000*exp(-((t-0.8)/0.001)^2)") +
      GetParam().solver("1", "0.05");
  const PreparedMechanism whole = prepared(text);
  const RunResult once = run(*whole.mechanism, whole.state, whole.v_dot, whole.options);
  for (const double stop : {0.3, 0.5, 0.505, 0.51, 0.8}) {
    SolverOptions first = whole.options;
    first.stop_time = stop;
    const RunResult part = run(*whole.mechanism, whole.state, whole.v_dot, first);
    ASSERT_TRUE(part.stopped_as_told) << part.stopped_because;
    const RunResult rest = run(*whole.mechanism, part.continuation, whole.options);
    ASSERT_TRUE(rest.complete) << rest.stopped_because;
    EXPECT_EQ(rest.state.p(0), once.state.p(0)) << stop;
    EXPECT_EQ(rest.state.v(0), once.state.v(0)) << stop;
    EXPECT_EQ(rest.energy.work_in, once.energy.work_in) << stop;
  }
}

TEST_P(TimeEvents, ConditionsOnTheMotionAreLocated) {
  // One-sided spring: at 0 after 1 s, half a period in it, back.
  const std::string spring = pushed_by("s.position > 0 ? -100*s.position : 0");
  const auto with_start = [](std::string text, const std::string& position, const std::string& speed) {
    const std::string joint = "to = \"m.s\"\n";
    text.replace(text.find(joint), joint.size(),
                 joint + "position = " + position + "\nspeed = " + speed + "\n");
    return text;
  };
  const double alpha = GetParam().name == "generalised_alpha" ? 3e3 : 1.0;  // second order
  const double fixed = GetParam().fixed_step.empty() ? 1.0 : 300.0;         // a step of 0.07 in pi/10
  const Series there = simulated(with_start(spring, "-1", "1") + GetParam().solver("3"), {"s.position"});
  EXPECT_NEAR(there.values.back()(0), -(2.0 - M_PI / 10.0), 1e-5 * alpha * fixed);
  ASSERT_EQ(there.result.events.size(), 2u);
  EXPECT_NEAR(there.result.events[0].t, 1.0, 1e-9);
  // A constant force to the middle: parabolas, a period of 4 s.
  const Series swings = simulated(
      with_start(pushed_by("s.position > 0 ? -1 : 1"), "0.5", "0") + GetParam().solver("4"), {"s.position"});
  EXPECT_NEAR(swings.values.back()(0), 0.5, 1e-8);
  // A narrow field that the mass flies through: 1 cm at 1 N.
  const Series field = simulated(
      with_start(pushed_by("s.position > 1 && s.position < 1.01 ? 1 : 0"), "0", "1") + GetParam().solver("3"),
      {"s.speed"});
  EXPECT_NEAR(field.values.back()(0), std::sqrt(1.02), 1e-8);
  // Stairs: 1 N in [0, 1), 2 N in [1, 2), 3 N in [2, 3).
  const Series stairs =
      simulated(with_start(pushed_by("1 + floor(s.position)"), "0", "0") + GetParam().solver("3", "0.01"),
                {"s.position", "s.speed"});
  for (const Eigen::VectorXd& row : stairs.values) {
    if (row(0) >= 3.0) break;
    const double n = std::floor(row(0)), work = n * (n + 1.0) / 2.0 + (n + 1.0) * (row(0) - n);
    EXPECT_NEAR(row(1) * row(1), 2.0 * work, 1e-7);
  }
}

TEST_P(TimeEvents, ThereAndBackWithinOneStepIsSeen) {
  // A throw whose top lies 1 cm within a field.
  std::string text = pushed_by("s.position > 4.99 ? -20 : -10");
  const std::string joint = "to = \"m.s\"\n";
  text.replace(text.find(joint), joint.size(), joint + "speed = 10\n");
  const Series thrown = simulated(text + GetParam().solver("2"), {"s.speed"});
  // To the top of the field at the speed v it is entered with: twice v/20 s there instead of v/10 s.
  const double v = std::sqrt(100.0 - 2.0 * 10.0 * 4.99), lost = 2.0 * v / 10.0 - 2.0 * v / 20.0;
  EXPECT_NEAR(thrown.values.back()(0), -10.0 - 10.0 * lost, 1e-7);
}

TEST_P(TimeEvents, ChatteringNamesTheFormula) {
  std::string text = pushed_by("-10*sign(s.speed)");
  const std::string joint = "to = \"m.s\"\n";
  text.replace(text.find(joint), joint.size(), joint + "speed = 1\n");
  const PreparedMechanism p = prepared(text + GetParam().solver("1"));
  const RunResult r = run(*p.mechanism, p.state, p.v_dot, p.options);
  EXPECT_FALSE(r.complete);
  EXPECT_NEAR(r.state.t, 0.1, 1e-6);
  EXPECT_NE(r.stopped_because.find("force.f.z = \"-10*sign(s.speed)\" switches without end at t = 0.1"),
            std::string::npos)
      << r.stopped_because;
}

TEST_P(TimeEvents, EndlessOnesAreRefusedSoon) {
  for (const char* formula : {"floor(1e6*t)", "mod(1e6*t, 1)"}) {
    const PreparedMechanism p = prepared(pushed_by(formula) + GetParam().solver());
    const RunResult r = run(*p.mechanism, p.state, p.v_dot, p.options);
    EXPECT_FALSE(r.complete) << formula;
    EXPECT_NE(r.stopped_because.find("times until the end"), std::string::npos)
        << formula << ": " << r.stopped_because;
  }
}

TEST_P(TimeEvents, KinksKeepTheOrder) {
  // Straight pieces make cubic motions, which every method of order three and more follows exactly; of order
  // two by steps that end at the kinks: the error falls by four with half the step.
  const std::string table =
      "[table.zigzag]\nx = [0, 0.111, 0.237, 0.5, 1]\ny = [0, 3, -2, 4, 1]\n"
      "interpolation = \"linear\"\n";
  const double impulse = 0.5 * (0.111 * 3 + 0.126 * 1 + 0.263 * 2 + 0.5 * 5);
  const Series s = simulated(pushed_by("zigzag(t)") + table + GetParam().solver("1"), {"s.speed"});
  const bool exact = GetParam().name == "runge_kutta" || GetParam().name == "radau";
  EXPECT_NEAR(s.values.back()(0), impulse, exact ? 1e-12 : GetParam().fixed_step.empty() ? 1e-4 : 0.02);
}

TEST_P(TimeEvents, DrivesJumpInSpeedButNotInPosition) {
  std::string text = slider;
  const std::string joint = "to = \"m.s\"\n";
  const auto driven = [&](const std::string& drive) {
    std::string t = text;
    return t.replace(t.find(joint), joint.size(), joint + "drive = \"" + drive + "\"\n") +
           GetParam().solver("1", "0.125");
  };
  const Series s = simulated(driven("t < 0.25 ? 0 : 2*(t - 0.25)"), {"s.position", "s.speed"});
  EXPECT_NEAR(s.values[2](1), 0.0, 1e-9);
  EXPECT_NEAR(s.values[3](1), 2.0, 1e-9);
  EXPECT_NEAR(s.values.back()(0), 1.5, 1e-9);
  EXPECT_NEAR(s.result.energy.work_in, 2.0, 1e-6);
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-6);
  const PreparedMechanism p = prepared(driven("t < 0.25 ? 0 : 0.1"));
  const RunResult r = run(*p.mechanism, p.state, p.v_dot, p.options);
  EXPECT_NE(r.stopped_because.find("\"s.drive\" prescribes jumps by 0.1 (m or rad) at t = 0.25 s"),
            std::string::npos)
      << r.stopped_because;
}

TEST_P(TimeEvents, AreNotStored) {
  // A square wave of 1 MHz: 2000 jumps in a millisecond.
  const Series s = simulated(
      pushed_by("sin(2*pi*1e6*t) > 0 ? 1000 : 0") + GetParam().solver("0.001", "0.001"), {"s.speed"});
  EXPECT_NEAR(s.values.back()(0), 0.5, 1e-6);
  EXPECT_EQ(s.result.events.size(), 0u);
}

class ConstantFormula : public TextCase {};

TEST_F(ConstantFormula, WithoutAValueIsRefusedBeforeAnyMotion) {
  for (const char* formula : {"0/0", "log(-1)", "1e308*10", "sqrt(size - 200)"}) {
    const std::string why = refusal(pushed_by(formula));
    EXPECT_NE(why.find(std::string("force.f.z = \"") + formula + "\" is "), std::string::npos) << why;
    EXPECT_NE(why.find("a finite number is wanted"), std::string::npos) << why;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, TimeEvents, ::testing::ValuesIn(methods), name_of);

}  // namespace
}  // namespace flexura::mbs::cases
