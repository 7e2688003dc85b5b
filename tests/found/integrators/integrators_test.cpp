// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// Where integrators stall, and tolerances that follow the scene.  Steps are counted, never timed.
namespace flexura::test {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kFound = std::string(FLEXURA_SOURCE_DIR) + "/tests/found/";

class Integrators : public ::testing::Test {
 protected:
  struct Run {
    Outcome outcome;
    results::Run results;
    nlohmann::json summary;
    long steps() const { return summary.value("steps", -1L); }
    Eigen::VectorXd operator[](const std::string& name) const {
      for (std::size_t j = 0; j < results.quantities.size(); ++j)
        if (results.quantities[j].name == name) return results.values.col(static_cast<Eigen::Index>(j));
      ADD_FAILURE() << "no " << name;
      return {};
    }
  };
  Run simulate(const std::string& file, const std::vector<std::string>& set,
               const std::vector<std::string>& more = {"--no-estimate"}) const {
    const auto out = (folder_ / "out.h5").string();
    std::vector<std::string> arguments = {"simulate", file, "-o", out};
    for (const std::string& s : set) arguments.insert(arguments.end(), {"--set", s});
    arguments.insert(arguments.end(), more.begin(), more.end());
    Run run{test::run("flexura", arguments), {}, {}};
    if (run.outcome.exit_code == 2) return run;
    run.results = results::read(out).runs.front();
    run.summary = nlohmann::json::parse(run.results.summary_json);
    return run;
  }
  Folder folder_;
};

// A body 1e9 times as heavy as the one that carries it: that one's spin about its own axis has 0.1 kg m^2, in the axes of
// its ball joint beside 1e9, and the matrix changes by 1e9 (omega h)^2 as a step turns that axis by omega h.  Newton's
// method with one matrix for three stages contracts only below omega h = 1e-5: 344,252 steps of Radau for 0.4 s, where
// explicit Runge-Kutta takes 41 for 2 s. With a matrix for each stage Radau takes a few hundred.
TEST_F(Integrators, AHeavyBodyOnALightOneHoldsNoMethodUp) {
  const std::string file = kFound + "trade/scene_heavy.toml";
  const std::string text = replaced(read_text(file), "method=\"radau\"", "");
  const Run radau = simulate(file, {"solver.method=radau"}),
            open = simulate(folder_.write("heavy.toml", text).string(), {}),
            explicit_one = simulate(file, {"solver.method=runge_kutta"});
  for (const Run* run : {&radau, &open, &explicit_one})
    ASSERT_EQ(run->outcome.exit_code, 0) << run->outcome.err;
  EXPECT_LT(radau.steps(), 1000);
  EXPECT_LT(open.steps(), 5000);
  const Eigen::VectorXd x = explicit_one["j2.position"];
  for (const Run* run : {&radau, &open})
    EXPECT_LT(((*run)["j2.position"] - x).cwiseAbs().maxCoeff(), 1e-3 * x.cwiseAbs().maxCoeff());
  // It goes on from where it was cut, to the bit.
  const std::string state = (folder_ / "state.json").string();
  ASSERT_EQ(
      simulate(file, {"solver.stop_time=1"}, {"--no-estimate", "--save-state", state}).outcome.exit_code, 0);
  const Run rest = simulate(file, {}, {"--no-estimate", "--continue", state});
  ASSERT_EQ(rest.outcome.exit_code, 0) << rest.outcome.err;
  EXPECT_EQ(rest["j2.position"].tail(1)(0), radau["j2.position"].tail(1)(0));
}

// Contact of 1e8 N/m with nearly critical damping: IDA stayed at order one, every step failing once (20,000
// steps for a tenth of the run; Radau 859 for all of it).
TEST_F(Integrators, AStiffRollerContactDoesNotHoldIdaAtOrderOne) {
  const std::string file = kFound + "rigid/ida_stalls_roller_contact.toml";
  const Run ida = simulate(file, {"solver.method=ida", "solver.max_steps=60000"});
  ASSERT_EQ(ida.outcome.exit_code, 0) << ida.outcome.err;
  const Run radau = simulate(file, {"solver.method=radau"});
  const Eigen::VectorXd a = ida["fol.position"], b = radau["fol.position"];
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-6 * b.cwiseAbs().maxCoeff());
  // Without a word on the method the run is as fast as the better of the two, or nearly so.
  const Run open = simulate(file, {});
  EXPECT_LT(open.steps(), 10 * radau.steps());
}

// A run that changes its method by itself goes on to the bit where it was cut, before or behind the change.
TEST_F(Integrators, AnOpenMethodIsRepeatableAndGoesOn) {
  const std::string file = kFound + "rigid/ida_stalls_roller_contact.toml";
  const Run whole = simulate(file, {});
  ASSERT_EQ(whole.outcome.exit_code, 0) << whole.outcome.err;
  for (const char* const cut : {"0.02", "0.3"}) {
    const std::string state = (folder_ / "state.json").string();
    ASSERT_EQ(
        simulate(file, {std::string("solver.stop_time=") + cut}, {"--no-estimate", "--save-state", state})
            .outcome.exit_code,
        0);
    const Run rest = simulate(file, {}, {"--no-estimate", "--continue", state});
    ASSERT_EQ(rest.outcome.exit_code, 0) << rest.outcome.err;
    for (const char* const name : {"fol.position", "fol.speed", "c.normal_force"})
      EXPECT_EQ(rest[name].tail(1)(0), whole[name].tail(1)(0)) << cut << " " << name;
  }
}

// A parallelogram that turns freely at constant speed passes its change points, where its constraints lose
// rank; Radau crept into the ninth of them with steps down to 1e-12 s and stopped.
TEST_F(Integrators, AParallelogramTurnsThroughItsChangePoints) {
  const std::string file = kFound + "rigid/parallelogram_change_point.toml";
  for (const char* const method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    const Run run = simulate(file, {std::string("solver.method=") + method});
    ASSERT_EQ(run.outcome.exit_code, 0) << method << run.outcome.err;
    const Eigen::VectorXd angle = run["foot0.angle"];
    for (Eigen::Index i = 0; i < angle.size(); ++i)
      ASSERT_NEAR(angle(i), 0.5 * pi - 6.0 * run.results.time(i), 1e-4) << method;
  }
}

std::string oscillator(double amplitude) {
  return "gravity = [0, 0, 0]\n[ground.marker.rail]\naxis = [1, 0, 0]\n[body.mass]\nmass = 1\ninertia = [1, "
         "1, "
         "1]\n[body.mass.marker.pin]\naxis = [1, 0, 0]\n[joint.slide]\ntype = \"prismatic\"\nfrom = "
         "\"ground.rail\"\nto = \"mass.pin\"\nposition = " +
         std::to_string(1e15 * amplitude) +
         "e-15\n[force.spring]\ntype = \"joint_spring_damper\"\njoint = \"slide\"\nstiffness = "
         "100\n[output]\n"
         "quantities = [\"slide.position\"]\n";
}

// x = a cos 10 t, two periods.  The absolute tolerance was 1e-8 m whatever the scene: 110 % wrong at
// nanometres, and ten times the steps at megametres.
TEST_F(Integrators, AnOscillationIsAsAccurateAtNanometresAsAtMetres) {
  for (const char* const method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    std::vector<long> steps;
    for (const double a : {1e-9, 28e-9, 1e-3, 1.0, 1e3}) {
      const auto file = folder_.write("oscillator.toml", oscillator(a));
      const Run run =
          simulate(file.string(), {std::string("solver.method=") + method, "solver.end_time=1.2566"});
      ASSERT_EQ(run.outcome.exit_code, 0) << run.outcome.err;
      const Eigen::VectorXd x = run["slide.position"];
      double error = 0.0;
      for (Eigen::Index i = 0; i < x.size(); ++i)
        error = std::max(error, std::abs(x(i) / a - std::cos(10.0 * run.results.time(i))));
      // At every size within 2.4e-4 of the amplitude.
      EXPECT_LT(error, 4e-4) << method << " " << a;
      steps.push_back(run.steps());
    }
    const auto [least, most] = std::ranges::minmax_element(steps);
    EXPECT_LT(*most, 2 * *least) << method;
  }
}

// A fixed step is taken as given: a tenth of the run was its silent bound.
TEST_F(Integrators, AFixedStepIsNotShortened) {
  const auto file = folder_.write("oscillator.toml", oscillator(1.0)).string();
  for (const char* const method : {"generalised_alpha", "runge_kutta"}) {
    const Run run = simulate(file, {std::string("solver.method=") + method, "solver.end_time=0.1",
                                    "solver.fixed_step=0.025", "solver.output_step=0.1"});
    ASSERT_EQ(run.outcome.exit_code, 0) << run.outcome.err;
    EXPECT_EQ(run.steps(), 4) << method;
    const Run refused = simulate(
        file, {std::string("solver.method=") + method, "solver.fixed_step=0.025", "solver.max_step=0.01"});
    EXPECT_EQ(refused.outcome.exit_code, 2);
    EXPECT_THAT(refused.outcome.err, HasSubstr("max_step"));
  }
}

// 1 N on 1 kg for 2e6 s leads 2e12 m away, where round-off is far above what a mechanism of 1 m is held to: IDA stopped
// there, "the tolerance is below what double precision can meet".
TEST_F(Integrators, AFreeBodyGoesAsFarAsItsForceDrivesIt) {
  const auto file =
      folder_.write("free.toml",
                    "gravity = [0, 0, 0]\n[body.m]\nmass = 1\ninertia = [1, 1, 1]\n[force.f]\ntype = "
                    "\"force\"\nmarker = \"m\"\nx = 1\n[output]\nquantities = "
                    "[\"m.position_x\"]\n[solver]\nend_time = 2e6\noutput_step = 1e5\n");
  for (const char* const method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    const Run run = simulate(file.string(), {std::string("solver.method=") + method});
    ASSERT_EQ(run.outcome.exit_code, 0) << method << run.outcome.err;
    EXPECT_LT(run.steps(), 1000) << method;
    const Eigen::VectorXd x = run["m.position_x"];
    // A parabola is exact for all of them but for what starts it.
    for (Eigen::Index i = 1; i < x.size(); ++i)
      EXPECT_NEAR(x(i) / (0.5 * run.results.time(i) * run.results.time(i)), 1.0, 1e-6) << method;
  }
}

// No method comes to the end of 1e10 rad/s for ten seconds, whether it was asked for by name or not: hours of steps that are
// right, each.
TEST_F(Integrators, WhatWouldNeverEndStops) {
  const std::string file = kFound + "integrators/spring_that_grinds.toml";
  for (const char* method : {"radau", "runge_kutta"}) {
    const Run run = simulate(file, {std::string("solver.method=") + method});
    EXPECT_EQ(run.outcome.exit_code, 1) << method;
    EXPECT_THAT(run.outcome.err, HasSubstr(std::string(method) + " creeps at t = "));
    EXPECT_THAT(run.outcome.err, HasSubstr("\"j.speed\" changes fastest"));
    EXPECT_GE(run.results.time.size(), 1);
  }
}

// Position and speed at t of 1 kg from rest at 0 with 1 m/s, under 4 N sin(3 t) and a dry friction of 3 N: it slips by a
// closed form and sticks where its speed comes to nothing until the push is above 3 N.
std::pair<double, double> dry_friction(double t_end) {
  double t = 0.0, x = 0.0, v = 1.0, sign = 1.0;
  const auto speed = [&](double at) {
    return v + 4.0 / 3.0 * (std::cos(3 * t) - std::cos(3 * at)) - 3.0 * sign * (at - t);
  };
  const auto place = [&](double at) {
    const double h = at - t;
    return x + (v + 4.0 / 3.0 * std::cos(3 * t)) * h - 4.0 / 9.0 * (std::sin(3 * at) - std::sin(3 * t)) -
           1.5 * sign * h * h;
  };
  const auto first = [&](auto&& is_after) {
    double before = t, after = t;
    while (after < t_end && !is_after(after)) before = after, after = std::min(after + 1e-3, t_end);
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (before + after);
      (is_after(middle) ? after : before) = middle;
    }
    return after;
  };
  while (t < t_end) {
    const double rests = first([&](double at) { return sign * speed(at) < 0.0; });
    x = place(rests);
    if (rests >= t_end) return {x, speed(t_end)};
    v = 0.0;
    t = rests;
    t = first([&](double at) { return std::abs(4.0 * std::sin(3 * at)) > 3.0; });
    sign = std::sin(3 * t) > 0.0 ? 1.0 : -1.0;
  }
  return {x, 0.0};
}

// A range of 1e-9 m/s lay within the errors of speeds: of the stiffness that it found there Radau's Newton method took a
// joint that should slip for one that sticks (position off by 10 %, speed by 2 m/s, exit code 0). Ranges are looked for
// where the mechanism is disturbed at rest, by behaviour: a formula has them as well.
TEST_F(Integrators, FrictionOfANarrowRangeOfSpeedsIsResolvedOrRefused) {
  const std::string file = kFound + "integrators/friction_of_narrow_range.toml";
  const auto [x, v] = dry_friction(9.8);
  int right = 0;
  for (const char* method : {"", "ida", "radau"})
    for (const char* range : {"1e-8", "1e-9", "1e-12"}) {
      std::vector<std::string> set{std::string("force.f.transition_speed=") + range};
      if (*method) set.push_back(std::string("solver.method=") + method);
      const Run run = simulate(file, set);
      if (run.outcome.exit_code == 1) {
        EXPECT_THAT(run.outcome.err, HasSubstr("error: ")) << method << range;
        continue;
      }
      ++right;
      // 1e-5: seven times a hundred steps at a tolerance of 1e-6, of which some err by as much.
      EXPECT_NEAR(run["j.position"](98), x, 1e-5) << method << range;
      EXPECT_NEAR(run["j.speed"](98), v, 1e-5) << method << range;
    }
  EXPECT_GE(right, 6);
  const Run formula = simulate(
      folder_
          .write("formula.toml",
                 replaced(replaced(read_text(file), "\"joint_friction\"", "\"joint_force\""),
                          "coulomb = 3\ntransition_speed = 1e-9", "value = \"-3*tanh(1e9*j.speed)\""))
          .string(),
      {"solver.method=radau"});
  ASSERT_EQ(formula.outcome.exit_code, 0) << formula.outcome.err;
  EXPECT_NEAR(formula["j.position"](98), x, 1e-5);
}

// al^2 = 0.5 - t has no real solution after 0.5 s: 1e82 was stored, or rows that solve nothing.
TEST_F(Integrators, StopWhereAnAlgebraicStateLosesItsSolution) {
  for (const char* method : {"ida", "radau", "runge_kutta", "generalised_alpha"}) {
    SCOPED_TRACE(method);
    const Run run =
        simulate(kFound + "integrators/algebraic_no_solution.toml", {std::string("solver.method=") + method});
    EXPECT_EQ(run.outcome.exit_code, 1);
    EXPECT_THAT(run.outcome.err, HasSubstr(" at t = 0.5"));
    const Eigen::VectorXd al = run["al"];
    ASSERT_GT(al.size(), 10);
    for (Eigen::Index k = 0; k < al.size(); ++k) {
      const double t = run.results.time[static_cast<std::size_t>(k)];
      ASSERT_LE(t, 0.5 + 1e-9);
      // Near the fold either branch may be found; both solve the equation, to what Newton's iterations leave.
      EXPECT_NEAR(al(k) * al(k), 0.5 - t, 1e-8) << t;
    }
  }
}

}  // namespace
}  // namespace flexura::test
