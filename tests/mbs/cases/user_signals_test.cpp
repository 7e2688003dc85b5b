// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "mbs/solver/linear/linearise.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/mbs/model/checks.hpp"

/// Controls and measures out of a library of a user's own (user_signals.cpp) do what the program's own do.
namespace flexura::mbs::cases {
namespace {

using ::testing::HasSubstr;

class UserSignals : public TextCase {
 protected:
  /// The keys of an element of the library.
  static std::string user(const std::string& element, const std::string& keys) {
    return fmt::format("type = \"user\"\nlibrary = \"{}\"\nelement = \"{}\"\n{}", FLEXURA_USER_SIGNALS,
                       element, keys);
  }
  /// A double pendulum under torques that read everything, of the library's elements or of the program's own.
  static std::string pendulum(bool of_users) {
    const auto either = [&](const std::string& users, const std::string& own) {
      return of_users ? users : own;
    };
    return R"toml(
[body.a]
mass = 1
center = [0.3, 0, 0]
inertia = [0.02, 0.03, 0.04]
[body.a.marker.tip]
position = [0.5, 0, 0]
[body.b]
mass = 0.7
center = [0.2, 0.1, 0]
inertia = [0.02, 0.01, 0.03]
[joint.first]
type = "revolute"
from = "ground"
to = "a"
angle = 0.3
[joint.second]
type = "revolute"
from = "a.tip"
to = "b"
angle = 0.9
speed = 1.5
[input.push]
value = "0.1*sin(3*t)"

)toml" + either("", "[measure.r]\ntype = \"distance\"\nfrom = \"ground\"\nto = \"b\"\n") +
           "[measure.gap]\n" +
           either(user("gap", "markers = [\"ground\", \"b\"]\ninputs = [\"0.2 + 0.1*first.angle + push\"]\n"),
                  "type = \"expression\"\nvalue = \"r - 0.2 - 0.1*first.angle - push\"\n") +

           "[measure.x]\ntype = \"position\"\nfrom = \"a\"\nto = \"b.com\"\ndirection = [1, 0, 0]\n"
           "[measure.u]\ntype = \"velocity\"\nfrom = \"a\"\nto = \"b.com\"\ndirection = [0, 1, 0]\n"
           "[measure.flow]\n" +
           either(user("flow", "markers = [\"a\", \"b.com\"]\n"),
                  "type = \"expression\"\nvalue = \"u*x\"\n") +
           "[control.lag]\n" +
           either(user("lag",
                       "inputs = [\"gap + 0.3*second.speed\"]\nvalues = { time = \"50 ms\", start = 0.1 }\n"),
                  "type = \"filter\"\ninput = \"gap + 0.3*second.speed\"\ntime_constant = \"50 ms\"\nstart = "
                  "0.1\n") +
           "[control.cubic]\n" +
           either(user("cubic", "inputs = [\"cubic\", \"2*second.angle + lag\"]\n"),
                  "type = \"algebraic\"\nequation = \"cubic + cubic^3 - 2*second.angle - lag\"\n") +
           either("[control.limited]\n" +
                      user("saturation", "inputs = [\"4*cubic + flow\"]\nvalues = { size = 2 }\n"),
                  "") +
           "[force.push_first]\ntype = \"joint_force\"\njoint = \"first\"\nvalue = \"-3*gap - 2*lag\"\n"
           "[force.push_second]\ntype = \"joint_force\"\njoint = \"second\"\nvalue = \"-" +
           either("limited", "2*tanh((4*cubic + flow)/2)") +
           "\"\n[solver]\nend_time = 2\noutput_step = 0.1\ntolerance = 1e-10\n";
  }
};

// The markers "com" are at the bodies' centres.
std::string with_centres(std::string text) {
  return text + "[body.b.marker.com]\nposition = [0.2, 0.1, 0]\n";
}

TEST_F(UserSignals, AreTheProgramsOwnInMotionsAndLinearSystems) {
  const PreparedMechanism users = prepared(with_centres(pendulum(true))),
                          own = prepared(with_centres(pendulum(false)));
  const std::vector<std::string> names = {"first.angle", "second.speed", "gap", "flow", "lag", "cubic"};
  const Series a = simulate(users, names), b = simulate(own, names);
  ASSERT_EQ(a.values.size(), b.values.size());
  // 1e-10 in each of some hundred steps.
  for (std::size_t i = 0; i < a.values.size(); ++i)
    EXPECT_LT((a.values[i] - b.values[i]).cwiseAbs().maxCoeff(), 1e-7) << a.t[i];
  LineariseOptions inputs;
  inputs.signals = {0};
  const LinearSystem of_users = linearise(*users.mechanism, users.state, inputs),
                     of_own = linearise(*own.mechanism, own.state, inputs);
  ASSERT_EQ(of_users.states, of_own.states);
  // Central differences: 1e-10 of values of order 1, twice.
  EXPECT_LT((of_users.A - of_own.A).norm(), 1e-8 * of_own.A.norm());
  EXPECT_LT((of_users.B - of_own.B).norm(), 1e-8 * of_own.B.norm());
}

TEST_F(UserSignals, SatisfyTheIdentitiesOfAllElements) {
  const PreparedMechanism p = prepared(with_centres(pendulum(true)));
  for (const unsigned seed : {1u, 2u, 3u}) checks::all_identities_hold(*p.mechanism, seed);
}

TEST_F(UserSignals, HeldValuesAreNoDynamicStates) {
  // 3 Hz for 2 s from a quarter behind a rise: six rises.
  const PreparedMechanism p = prepared(
      "gravity = [0, 0, 0]\n[body.m]\nmass = 1\n[joint.j]\ntype = \"prismatic\"\nfrom = \"ground\"\nto = "
      "\"m\"\n"
      "position = 0.1\n[force.k]\ntype = \"joint_force\"\njoint = \"j\"\nvalue = "
      "\"-(6*pi)^2*j.position\"\n[control.n]\n" +
      user("counter", "inputs = [\"j.position\"]\n") +
      "[control.sampled]\ntype = \"sample\"\ninput = \"n\"\nperiod = 0.25\n"
      "[solver]\nend_time = 2\noutput_step = 0.1\ntolerance = 1e-8\n");
  EXPECT_EQ(p.mechanism->sizes().n_dyn, 4);
  EXPECT_EQ(p.mechanism->sizes().n_held, 4);
  EXPECT_EQ(linearise(*p.mechanism, p.state).states.size(), 2u);
  const Series s = simulate(p, {"n", "sampled"});
  // x = 0.1 cos(6 pi t) rises through 0 at t = 1/4 + k/3.
  for (std::size_t i = 0; i < s.t.size(); ++i)
    EXPECT_EQ(s.values[i](0), std::floor((s.t[i] - 0.25) * 3.0 + 1.0 + 1e-6)) << s.t[i];
}

TEST_F(UserSignals, RefuseWhatTheFileOrTheLibraryGetsWrong) {
  const auto with = [&](const std::string& more) { return refusal(wheel + more + solver); };
  EXPECT_THAT(with("[control.x]\n" + user("lag", "values = { time = 1 }\n")),
              HasSubstr("inputs has 0 entries, 1 are wanted"));
  EXPECT_THAT(with("[control.x]\n" + user("misplaced", "inputs = [\"t\"]\nvalues = { size = 1 }\n")),
              HasSubstr("feeds through and does not stand in direct_controls"));
  EXPECT_THAT(with("[control.x]\n" + user("hidden", "inputs = [\"t\"]\n")),
              HasSubstr("gives an output that follows its inputs at once, and does not say so"));
  const PreparedMechanism unsure =
      prepared(wheel + "[control.x]\n" + user("unsure", "inputs = [\"t\"]\n") + solver);
  EXPECT_THAT(
      test::refusal_of([&] { run(*unsure.mechanism, unsure.state, unsure.v_dot, unsure.options, {}); }),
      HasSubstr("the switching function of \"x.switch_1\" is not a number at t = "));
  EXPECT_THAT(with("[control.x]\n" + user("gap", "")), HasSubstr("no control of this name"));
  EXPECT_THAT(with("[measure.x]\n" + user("gapp", "")), HasSubstr("did you mean \"gap\"?"));
  // What it reads is known to the library alone.
  EXPECT_THAT(
      refusal(wheel + "[control.x]\n" + user("cubic", "inputs = [\"x\", \"t\"]\n") +
              "[body.other]\nmass = 1\n[joint.led]\ntype = \"prismatic\"\nfrom = \"ground\"\nto = \"other\"\n"
              "drive = \"0.1*x\"\n" +
              solver),
      HasSubstr("\"x\" is an algebraic state without a formula"));
}

}  // namespace
}  // namespace flexura::mbs::cases
