// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

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
    const mbs::PreparedMechanism p =
        mbs::prepare(folder.write("mechanism.toml", motion.text),
                     {std::string("solver.method=") + method, fmt::format("solver.tolerance={}", tolerance),
                      "solver.end_time=0.5", "solver.output_step=0.01"});
    const auto which = mbs::select_quantities(*p.mechanism, p.file.outputs);
    const auto infos = p.mechanism->quantities();
    const auto scratch = p.mechanism->make_scratch();
    const auto error = GlobalError::make(p);
    ASSERT_TRUE(error);
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
    ASSERT_TRUE(run.complete) << run.stopped_because;
    const IntegratorEstimate estimate = error->estimate();
    // Unknown it may be only where it is large; it is never 0.
    if (!estimate.is_whole) {
      EXPECT_GT(std::sqrt(squares.cwiseQuotient(sizes).maxCoeff()), 0.3 * 0.05) << estimate.note;
      continue;
    }
    ASSERT_GT(estimate.error, 0.0);
    for (std::size_t k = 0; k < which.size(); ++k) {
      if (infos[static_cast<std::size_t>(which[k])].name != estimate.output) continue;
      ++judged;
      const auto j = static_cast<Eigen::Index>(k);
      // Each step rounds the state, which no estimate from the equations sees whole.
      const double off = std::sqrt(squares(j) / sizes(j)),
                   rounding = std::numeric_limits<double>::epsilon() * static_cast<double>(run.counts.steps);
      EXPECT_GT(estimate.error, 0.3 * off - rounding) << estimate.output << " is off by " << off;
      EXPECT_LT(estimate.error, 3.0 * off + rounding) << estimate.output << " is off by " << off;
    }
  }
  EXPECT_GT(judged, 200);
}

}  // namespace
}  // namespace flexura::study
