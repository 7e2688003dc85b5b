// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "mbs/controls/sample.hpp"
#include "mbs/forces/joint_force.hpp"
#include "mbs/joints/revolute.hpp"
#include "mbs/library/builder.hpp"
#include "mbs/library/simulation.hpp"
#include "mbs/solver/run/run.hpp"

/// Loops with a controller that samples: the method that is taken where none is named, and loops whose gain is too high.
namespace flexura::mbs {
namespace {

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A wheel whose sampled PD turns it to 1 rad.  Its exact motion from one sample to the next: with the error e = angle - 1 and
// a = -(k e + d speed) / I held, e' = e + T speed + T^2 a / 2, speed' = speed + T a.
struct Loop {
  double I, k, d, T;
  Eigen::Matrix2d next() const {
    const double e = k / I, v = d / I;
    Eigen::Matrix2d A;
    A << 1.0 - 0.5 * T * T * e, T - 0.5 * T * T * v, -T * e, 1.0 - T * v;
    return A;
  }
  double largest_eigenvalue() const { return next().eigenvalues().cwiseAbs().maxCoeff(); }
  Mechanism mechanism() const {
    MechanismBuilder b;
    const auto wheel = b.add("wheel", RigidBody{.mass = 1.0, .inertia = I * Matrix3d::Identity()});
    auto hinge = b.add<Revolute>("hinge", b.ground().marker(), wheel.marker());
    b.add<Sample>("torque", b.formula(fmt::format("{} * (1 - hinge.angle) - {} * hinge.speed", k, d)), T,
                  0.0);
    b.add<JointForce>("motor", hinge.coordinate(), b.formula("torque"));
    return b.build();
  }
};

// In units of the period, where the eigenvalues are those of a random point of the plane of the two gains.
Loop draw_loop(std::mt19937& random) {
  const auto draw = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const double T = std::pow(10.0, draw(-4.0, -1.0)), I = std::pow(10.0, draw(-4.0, 2.0));
  return {I, draw(0.05, 3.0) * I / (T * T), draw(0.1, 6.0) * I / T, T};
}

TEST(SampledLoops, StableOnesFollowTheirDifferenceEquationByTheMethodOfOneStep) {
  std::mt19937 random(31);  // NOLINT(cert-msc51-cpp): repeatable
  constexpr int kSamples = 100;
  int stable = 0;
  StepCounts of_open, of_ida;
  for (int i = 0; stable < 100; ++i) {
    const Loop loop = draw_loop(random);
    if (loop.largest_eigenvalue() > 0.97) continue;
    ++stable;
    SCOPED_TRACE(fmt::format("loop {}: I {} k {} d {} T {}", i, loop.I, loop.k, loop.d, loop.T));
    StartedMechanism started;
    started.mechanism = std::make_unique<Mechanism>(loop.mechanism().description());
    started.state = started.mechanism->initial_state();
    assemble_start(started, {started.mechanism->given_positions(), started.mechanism->given_velocities()});
    SolverOptions options = started.options;
    options.end_time = kSamples * loop.T;
    options.output_step = loop.T;
    options.method_is_open = true;
    Eigen::Vector2d x(-1.0, 0.0);
    double largest = 1.0, error = 0.0;
    RunCallbacks callbacks;
    callbacks.row = [&](const State& s, const Eigen::VectorXd&, const EnergyAccount&) {
      if (s.t > 0.0) x = loop.next() * x;
      largest = std::max(largest, std::abs(x(0)));
      error = std::max(error, std::abs(s.p(0) - 1.0 - x(0)));
    };
    const RunResult open = run(*started.mechanism, started.state, started.v_dot, options, callbacks);
    ASSERT_TRUE(open.complete) << open.stopped_because;
    // The tolerance of 1e-6 in each of some steps between a hundred samples.
    EXPECT_LT(error, 1e-4 * largest);
    EXPECT_THAT(open.method_changes, ElementsAre(HasSubstr("from ida to radau")));
    options.method_is_open = false;
    const RunResult ida = run(*started.mechanism, started.state, started.v_dot, options);
    for (long StepCounts::*count : {&StepCounts::steps, &StepCounts::evaluations, &StepCounts::jacobians}) {
      of_open.*count += open.counts.*count;
      of_ida.*count += ida.counts.*count;
    }
  }
  // Of a wheel that turns freely between its samples, the first fifth by ida: half the steps, two thirds of the evaluations, two
  // fifths of the matrices.
  EXPECT_LT(static_cast<double>(of_open.steps), 0.6 * static_cast<double>(of_ida.steps));
  EXPECT_LT(static_cast<double>(of_open.evaluations), 0.8 * static_cast<double>(of_ida.evaluations));
  EXPECT_LT(static_cast<double>(of_open.jacobians), 0.5 * static_cast<double>(of_ida.jacobians));
}

// The motion is that of the difference equation until the run stops, long before numbers end and soon after it has gone 1000
// times round.
TEST(SampledLoops, UnstableOnesStopWithTheReason) {
  std::mt19937 random(32);  // NOLINT(cert-msc51-cpp): repeatable
  int unstable = 0;
  for (int i = 0; unstable < 200; ++i) {
    const Loop loop = draw_loop(random);
    if (loop.largest_eigenvalue() < 1.1) continue;
    ++unstable;
    SCOPED_TRACE(fmt::format("loop {}: I {} k {} d {} T {} grows by {}", i, loop.I, loop.k, loop.d, loop.T,
                             loop.largest_eigenvalue()));
    // Ten factors of ten of the energy and 1000 rad are there at 1e9 rad; the sample that leads there may be the next.
    Eigen::Vector2d x(-1.0, 0.0);
    int n = 0;
    for (; std::abs(x(0)) < 1e9; ++n) x = loop.next() * x;
    Simulation s(loop.mechanism(), {.end_time = 2.0 * n * loop.T});
    std::string reason;
    try {
      for (int k = 0; k < n + 1; ++k) s.advance(loop.T);
    } catch (const std::runtime_error& e) {
      reason = e.what();
    }
    EXPECT_THAT(reason, HasSubstr("grows without bound: since t = "));
    EXPECT_THAT(reason, HasSubstr("\"hinge.speed\" goes farthest"));
  }
}

// The program's own loop is one, too: what it sets each period makes the events.
TEST(SampledLoops, InputsSetEachPeriodChooseTheMethod) {
  MechanismBuilder b;
  const auto wheel = b.add("wheel", RigidBody{.mass = 1.0, .inertia = Matrix3d::Identity()});
  auto hinge = b.add<Revolute>("hinge", b.ground().marker(), wheel.marker());
  b.input("torque", "0");
  b.add<JointForce>("motor", hinge.coordinate(), b.formula("torque - 10 * sin(hinge.angle)"));
  Simulation s(b.build());
  for (int k = 0; k < 50; ++k) {
    s.set_input("torque", 20.0 * (1.0 - s.output("hinge.angle")) - s.output("hinge.speed"));
    s.advance(1e-2);
  }
  EXPECT_THAT(s.notes(),
              ElementsAre(AllOf(HasSubstr("method changed from ida to radau"), HasSubstr("every 0.01 s"))));
}

}  // namespace
}  // namespace flexura::mbs
