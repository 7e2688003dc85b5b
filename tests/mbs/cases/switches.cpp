// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>

#include "tests/mbs/cases/case_run.hpp"

/// Contacts, play and friction against the exact times at which they switch. All integrators locate switches
/// on their own polynomials, whose error at a tolerance of 1e-10 is below 1e-8 s at the speeds of these
/// cases.
namespace flexura::mbs::cases {
namespace {

// Times of the events of one switch, by its name.
std::vector<double> times(const PreparedMechanism& p, const RunResult& r, const std::string& name) {
  std::vector<double> t;
  for (const RootEvent& event : r.events)
    if (p.mechanism->name_of_root(event.which) == name) t.push_back(event.t);
  return t;
}

class Switching : public ::testing::TestWithParam<const char*> {
 protected:
  std::vector<std::string> with_method(std::vector<std::string> overrides = {}) const {
    overrides.push_back(fmt::format("solver.method={}", GetParam()));
    return overrides;
  }
};

TEST_P(Switching, BallTouchesAndLeavesTheFloorAtTheExactTimes) {
  const PreparedMechanism p = prepare_case("switches/bouncing_ball.toml", with_method());
  const Series s = simulate(p, {"fall.position", "energy.total"});
  const double g = 9.81, omega = 100.0, v = std::sqrt(2.0 * g);
  // In contact delta = g / omega^2 (1 - cos) + v / omega sin: back at 0 after omega t = 2 (pi - atan(v omega
  // / g)).
  const double touching = 2.0 / omega * (M_PI - std::atan(v * omega / g));
  const std::vector<double> found = times(p, s.result, "floor.gap");
  ASSERT_GE(found.size(), 4u);
  double t = v / g;
  for (std::size_t k = 0; k + 1 < found.size(); k += 2) {
    EXPECT_NEAR(found[k], t, 1e-8) << "touch-down " << k / 2;
    EXPECT_NEAR(found[k + 1], t + touching, 1e-8) << "lift-off " << k / 2;
    t += touching + 2.0 * v / g;
  }
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-7 * g);
}

TEST_P(Switching, DampedContactLetsGoWhereItWouldPull) {
  const PreparedMechanism p =
      prepare_case("switches/bouncing_ball.toml",
                   with_method({"gravity=[0, 0, 0]", "joint.fall.position=0.06", "joint.fall.speed=-1",
                                "force.floor.damping=40", "solver.end_time=0.1"}));
  const Series s = simulate(p, {"fall.speed"});
  // delta = v / w_d exp(-a t) sin(w_d t); k delta + d delta' = 0 where tan(w_d t) = -d w_d / (k - d a).
  const double k = 1e4, d = 40.0, a = 0.5 * d, w_d = std::sqrt(k - a * a);
  const double lift_off = 0.01 + (M_PI - std::atan(d * w_d / (k - d * a))) / w_d;
  const std::vector<double> found = times(p, s.result, "floor.push");
  ASSERT_FALSE(found.empty());
  bool met = false;
  for (const double t : found) met = met || std::abs(t - lift_off) < 1e-8;
  EXPECT_TRUE(met) << lift_off;
  // Free flight afterwards, with delta' at the lift-off.
  const double t = lift_off - 0.01;
  const double speed = -std::exp(-a * t) * (std::cos(w_d * t) - a / w_d * std::sin(w_d * t));
  EXPECT_NEAR(s.values.back()(0), speed, 1e-8);
}

TEST_P(Switching, RestitutionIsExactForAnyExponent) {
  for (const double e : {0.3, 0.8}) {
    const PreparedMechanism p =
        prepare_case("switches/bouncing_ball.toml",
                     with_method({"gravity=[0, 0, 0]", "joint.fall.position=0.06", "joint.fall.speed=-2",
                                  "force.floor.exponent=1.5", fmt::format("force.floor.restitution={}", e),
                                  "solver.end_time=0.5"}));
    const Series s = simulate(p, {"fall.speed"});
    EXPECT_NEAR(s.values.back()(0), 2.0 * e, 1e-8) << e;
    EXPECT_LT(std::abs(s.result.energy.error()), 1e-8);
  }
}

TEST_P(Switching, TeethMeetTheirFlanksAtTheExactTimes) {
  const PreparedMechanism p = prepare_case("switches/backlash.toml", with_method());
  const Series s = simulate(p, {"teeth.position", "teeth.force"});
  // x = r_1 q_1 + r_2 q_2 moves with v between the flanks and swings with omega on them.
  const double r_1 = 0.05, r_2 = 0.08, v = 3.0 * r_1, k = 1e6, play = 2e-4;
  const double omega = std::sqrt(k * (r_1 * r_1 / 2e-3 + r_2 * r_2 / 8e-3));
  const std::vector<double> lower = times(p, s.result, "teeth.lower_gap"),
                            upper = times(p, s.result, "teeth.upper_gap");
  ASSERT_GE(lower.size(), 4u);
  ASSERT_GE(upper.size(), 4u);
  double t = 0.5 * play / v;
  for (std::size_t i = 0; i + 1 < std::min(lower.size(), upper.size()); i += 2) {
    EXPECT_NEAR(upper[i], t, 1e-8);
    EXPECT_NEAR(upper[i + 1], t + M_PI / omega, 1e-8);
    t += M_PI / omega + play / v;
    EXPECT_NEAR(lower[i], t, 1e-8);
    EXPECT_NEAR(lower[i + 1], t + M_PI / omega, 1e-8);
    t += M_PI / omega + play / v;
  }
}

TEST(StickSlip, BlockBreaksAwayAndIsCaughtAtTheExactTimes) {
  const PreparedMechanism p = prepare_case("switches/stick_slip.toml");
  const Series s = simulate(p, {"friction.sticks", "friction.force"});
  const std::vector<double> found = times(p, s.result, "friction.stick");
  // Rides along until c x = F_s; slips about F_c / c from there with the belt's speed V until it has that
  // again; is then as far below F_c / c as it was above.
  const double c = 100.0, V = 0.1, F_s = 3.0, F_c = 2.0, omega = 10.0;
  const double slipping = 2.0 / omega * (M_PI - std::atan((F_s - F_c) * omega / (c * V)));
  const double riding = 2.0 * (F_s - F_c) / (c * V);
  ASSERT_GE(found.size(), 6u);
  double t = F_s / (c * V);
  for (std::size_t k = 0; k + 1 < found.size(); k += 2) {
    EXPECT_NEAR(found[k], t, 1e-8) << "breaks away " << k / 2;
    EXPECT_NEAR(found[k + 1], t + slipping, 1e-8) << "is caught " << k / 2;
    t += slipping + riding;
  }
}

INSTANTIATE_TEST_SUITE_P(Integrators, Switching, ::testing::Values("ida", "runge_kutta"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace flexura::mbs::cases
