// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "mbs/mechanism/describe.hpp"
#include "mbs/study/estimate/global_error.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/solver/exact_motions.hpp"

/// The integrator's share that a run tells of itself, against motions known in closed form, for every integrator at
/// tolerances down to 1e-12.
namespace flexura::study {
namespace {

using Eigen::Vector3d;
using mbs::test::ExactMotion;
using test::Folder;
using Random = std::mt19937;

double draw(Random& random, double least, double most) {
  return std::uniform_real_distribution<double>(least, most)(random);
}
// With either sign, and not near zero.
double draw_away(Random& random, double most) {
  return (random() % 2 == 0 ? 1.0 : -1.0) * draw(random, 0.3 * most, most);
}

// ODE with quaternions.
ExactMotion any_top(Random& random) {
  const double J = draw(random, 0.1, 0.3), J_e = J * draw(random, 0.4, 1.6);
  const Vector3d w(draw_away(random, 3.0), draw_away(random, 3.0), draw_away(random, 6.0));
  const Vector3d turn(draw_away(random, 1.5), draw_away(random, 1.0), 0.0);
  return mbs::test::free_top(J, J_e, w, turn);
}

ExactMotion any_oscillator(Random& random) {
  const double w = draw(random, 3.0, 40.0), zeta = draw(random, 0.0, 0.4), x0 = draw_away(random, 1.0),
               v0 = w * draw_away(random, 1.0);
  return mbs::test::damped_oscillator(w, zeta, x0, v0);
}

ExactMotion any_sling(Random& random) {
  const double r = draw(random, 0.5, 3.0), w = draw_away(random, 6.0), m = draw(random, 1.0, 5.0);
  return mbs::test::sling(m, r, w);
}

// What a run tells of itself, and how far its outputs are off, relative to their rms.
struct Told {
  IntegratorEstimate estimate;
  std::vector<std::string> names;
  Eigen::VectorXd off;
  long steps = 0;
  double off_of(const std::string& name) const {
    const auto found = std::ranges::find(names, name);
    return found == names.end() ? -1.0 : off(found - names.begin());
  }
};

Told tell(const Folder& folder, const ExactMotion& motion, const std::string& method, double tolerance,
          double end_time, double output_step) {
  const mbs::PreparedMechanism p = mbs::prepare(
      folder.write("mechanism.toml", motion.text),
      {"solver.method=" + method, fmt::format("solver.tolerance={}", tolerance),
       fmt::format("solver.end_time={}", end_time), fmt::format("solver.output_step={}", output_step)});
  const auto which = mbs::select_quantities(*p.mechanism, p.file.outputs);
  const auto infos = p.mechanism->quantities();
  const auto scratch = p.mechanism->make_scratch();
  const auto error = GlobalError::make(p);
  Told out;
  for (const int i : which) out.names.push_back(infos[static_cast<std::size_t>(i)].name);
  Eigen::VectorXd y(static_cast<Eigen::Index>(which.size())), squares = Eigen::VectorXd::Zero(y.size()),
                                                              sizes = squares;
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
    p.mechanism->evaluate(which, s, v_dot, *scratch, y);
    const Eigen::VectorXd exact = motion.outputs(s.t);
    squares += (y - exact).cwiseAbs2();
    sizes += exact.cwiseAbs2();
  };
  error->watch(callbacks);
  const mbs::RunResult run = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  EXPECT_TRUE(run.complete) << run.stopped_because;
  out.estimate = error->estimate();
  out.off = squares.cwiseQuotient(sizes).cwiseSqrt();
  out.steps = run.counts.steps;
  return out;
}

TEST(IntegratorsShareOfExactMotions, IsWithinAFactorOfThreeAtEveryTolerance) {
  Random random(20261127);
  const Folder folder;
  const std::pair<const char*, double> methods[] = {
      {"ida", -12.0}, {"radau", -12.0}, {"runge_kutta", -12.0}, {"generalised_alpha", -8.0}};
  ExactMotion (*const kinds[])(Random&) = {any_top, any_oscillator, any_sling};
  int judged = 0;
  for (int i = 0; i < 240; ++i) {
    const ExactMotion motion = kinds[i % 3](random);
    const auto& [method, finest] = methods[i / 3 % 4];
    const double tolerance = std::pow(10.0, draw(random, finest, -5.0));
    SCOPED_TRACE(fmt::format("{}: {} at {}\n{}", i, method, tolerance, motion.text));
    const Told told = tell(folder, motion, method, tolerance, 0.5, 0.01);
    const IntegratorEstimate& estimate = told.estimate;
    // Unknown it may be only where it is large; it is never 0.
    if (!estimate.is_whole) {
      EXPECT_GT(told.off.maxCoeff(), 0.3 * 0.05) << estimate.note;
      continue;
    }
    ASSERT_GT(estimate.error, 0.0);
    const double off = told.off_of(estimate.output);
    if (off < 0.0) continue;
    ++judged;
    // Each step rounds the state, which no estimate from the equations sees whole.
    const double rounding = std::numeric_limits<double>::epsilon() * static_cast<double>(told.steps);
    EXPECT_GT(estimate.error, 0.3 * off - rounding) << estimate.output << " is off by " << off;
    EXPECT_LT(estimate.error, 3.0 * off + rounding) << estimate.output << " is off by " << off;
  }
  EXPECT_GT(judged, 200);
}

// A spring under a mass, on ground that is shaken or still.
mbs::test::ShakenSpring any_spring(Random& random, double slowest, double fastest, double least_damped) {
  mbs::test::ShakenSpring spring;
  spring.w = std::pow(10.0, draw(random, slowest, fastest));
  spring.zeta = random() % 2 == 0 ? 0.0 : std::pow(10.0, draw(random, least_damped, -0.5));
  spring.y0 = -9.81 / (spring.w * spring.w) * draw(random, 0.0, 1.0);
  if (random() % 2 == 0) {
    spring.A = std::pow(10.0, draw(random, -3.0, -0.5));
    spring.W = draw(random, 3.0, 30.0);
  }
  spring.cart = random() % 2 == 0;
  return spring;
}

// A vibration that moves less than the tolerance of what swings beside it, or is faster than the steps, carries the only force that is
// stored: 5e-8 % was told of 6 %, 0.2 % of 4 % where the steps damp it.
TEST(IntegratorsShareOfExactMotions, CoversForcesOfWhatHardlyMoves) {
  Random random(20261128);
  const Folder folder;
  const char* const methods[] = {"ida", "radau", "generalised_alpha", "runge_kutta"};
  int judged = 0, above = 0;
  constexpr int kCases = 240;
  for (int i = 0; i < kCases; ++i) {
    // Two of six vibrate up to ten million times in a second, and only integrators that damp step over it.
    const bool is_damped = i % 6 < 2;
    const std::string method = methods[is_damped ? i % 2 : i % 4];
    const mbs::test::ShakenSpring spring =
        is_damped ? any_spring(random, 4.0, 7.8, -7.0) : any_spring(random, 1.0, 5.5, -4.0);
    const ExactMotion motion = mbs::test::shaken_spring(spring);
    const double tolerance = std::pow(10.0, is_damped ? draw(random, -5.0, -2.0) : draw(random, -7.0, -3.0)),
                 // So many radians of the vibration are followed in some thousands of steps.
        turns = draw(random, 1.0, is_damped ? 4.0 : 3.5),
                 end_time = std::min(1.0, std::pow(10.0, turns) / spring.w);
    SCOPED_TRACE(fmt::format("{}: {} at {} until {}\n{}", i, method, tolerance, end_time, motion.text));
    // All rows of the estimate are rows here: of 200 it looks at each.
    const Told told = tell(folder, motion, method, tolerance, end_time, end_time / 197.0);
    const IntegratorEstimate& estimate = told.estimate;
    const double off = told.off(0);
    // Above 5 % it is unknown.
    if (!estimate.is_whole) {
      EXPECT_GT(off, 0.3 * 0.05) << estimate.note;
      continue;
    }
    ++judged;
    // Each step rounds the state, which no estimate from the equations sees whole.
    const double rounding = std::numeric_limits<double>::epsilon() * static_cast<double>(told.steps);
    EXPECT_GT(estimate.error, 0.3 * off - rounding) << "it is off by " << off;
    above += estimate.error > 3.0 * off + rounding;
    EXPECT_LT(estimate.error, 10.0 * off + rounding) << "it is off by " << off;
  }
  EXPECT_GT(judged, 210);
  EXPECT_LE(above, 2);
}

}  // namespace
}  // namespace flexura::study
