// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "mbs/mechanism/describe.hpp"
#include "mbs/study/estimate/global_error.hpp"
#include "tests/app/command.hpp"

/// The integrator's share that a run tells of itself, against motions known in closed form, for every integrator at
/// tolerances down to 1e-12.
namespace flexura::study {
namespace {

using Eigen::Vector3d;
using test::Folder;
using Random = std::mt19937;

double draw(Random& random, double least, double most) {
  return std::uniform_real_distribution<double>(least, most)(random);
}
// With either sign, and not near zero.
double draw_away(Random& random, double most) {
  return (random() % 2 == 0 ? 1.0 : -1.0) * draw(random, 0.3 * most, most);
}

struct Motion {
  std::string text;                                     ///< the mechanism's file
  std::function<Eigen::VectorXd(double t)> quantities;  ///< its outputs
};

// ODE with quaternions: a round body without loads, turned at its start, turns about its axis e by
// Omega = (1 - J_e / J) w_e while e goes round the angular momentum by |L| / J (L. D. Landau, E. M. Lifshitz, Mechanics,
// section 33).
Motion free_top(Random& random) {
  const double J = draw(random, 0.1, 0.3), J_e = J * draw(random, 0.4, 1.6);
  const Vector3d w(draw_away(random, 3.0), draw_away(random, 3.0), draw_away(random, 6.0));
  const Vector3d turn(draw_away(random, 1.5), draw_away(random, 1.0), 0.0);
  const Vector3d e = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * Vector3d::UnitZ();
  const Vector3d L = J * w + (J_e - J) * w.dot(e) * e;
  return {
      fmt::format(R"toml(gravity = [0, 0, 0]
[body.a]
mass = 2
inertia = [{0}, {0}, {1}]
rotation = [{2}, {3}, 0]
angular_velocity = [{4}, {5}, {6}]
[output]
quantities = ["a.angular_velocity_*"]
)toml",
                  J, J_e, turn.x(), turn.y(), w.x(), w.y(), w.z()),
      [=](double t) -> Eigen::VectorXd { return Eigen::AngleAxisd(L.norm() / J * t, L.normalized()) * w; }};
}

// ODE: a mass on a spring with a damper.
Motion oscillator(Random& random) {
  const double w = draw(random, 3.0, 40.0), zeta = draw(random, 0.0, 0.4), x0 = draw_away(random, 1.0),
               v0 = w * draw_away(random, 1.0), w_d = w * std::sqrt(1.0 - zeta * zeta);
  return {fmt::format(R"toml(gravity = [0, 0, 0]
[ground.marker.m]
[body.a]
mass = 1
inertia = [1, 1, 1]
[body.a.marker.m]
[joint.j]
type = "prismatic"
from = "ground.m"
to = "a.m"
position = {}
speed = {}
[force.s]
type = "joint_spring_damper"
joint = "j"
stiffness = {}
damping = {}
[output]
quantities = ["j.position", "j.speed"]
)toml",
                      x0, v0, w * w, 2.0 * zeta * w),
          [=](double t) -> Eigen::VectorXd {
            const double decay = std::exp(-zeta * w * t), c = std::cos(w_d * t), s = std::sin(w_d * t);
            return Eigen::Vector2d(decay * (x0 * c + (v0 + zeta * w * x0) / w_d * s),
                                   decay * (v0 * c - (zeta * w * v0 + w * w * x0) / w_d * s));
          }};
}

// Index 2 (with generalised_alpha index 3): a mass on a thread goes round at even speed; its tension is m v^2 / r.
Motion sling(Random& random) {
  const double r = draw(random, 0.5, 3.0), w = draw_away(random, 6.0), m = draw(random, 1.0, 5.0);
  return {fmt::format(R"toml(gravity = [0, 0, 0]
[ground.marker.o]
[body.a]
mass = {}
inertia = [1, 1, 1]
[body.a.marker.c]
[joint.j]
type = "planar"
from = "ground.o"
to = "a.c"
x = {}
v_y = {}
[constraint.thread]
type = "distance"
from = "ground.o"
to = "a.c"
length = {}
[output]
quantities = ["j.x", "j.y", "thread.tension"]
)toml",
                      m, r, w * r, r),
          [=](double t) -> Eigen::VectorXd {
            return Vector3d(r * std::cos(w * t), r * std::sin(w * t), m * r * w * w);
          }};
}

TEST(IntegratorsShareOfExactMotions, IsWithinAFactorOfThreeAtEveryTolerance) {
  Random random(20261127);
  const Folder folder;
  const std::pair<const char*, double> methods[] = {
      {"ida", -12.0}, {"radau", -12.0}, {"runge_kutta", -12.0}, {"generalised_alpha", -8.0}};
  Motion (*const kinds[])(Random&) = {free_top, oscillator, sling};
  int judged = 0;
  for (int i = 0; i < 240; ++i) {
    const Motion motion = kinds[i % 3](random);
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
      const Eigen::VectorXd exact = motion.quantities(s.t);
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
