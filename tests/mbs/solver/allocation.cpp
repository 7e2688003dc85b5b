// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/integrators/integrator.hpp"
#include "mbs/solver/run/make_integrator.hpp"
#include "tests/mbs/allocations.hpp"
#include "tests/mbs/solver/flexible_engine.hpp"
#include "tests/mbs/started.hpp"
#include "tests/sanitized.hpp"

namespace flexura::mbs::test {
namespace {

class Allocations : public ::testing::TestWithParam<std::pair<const char*, bool>> {};

TEST_P(Allocations, OfAStepAreNone) {
#if defined(FLEXURA_ADDRESS_SANITIZER)
  GTEST_SKIP() << "the sanitizer owns malloc";
#endif
  const auto [method, closed] = GetParam();
  const Started start(flexible_engine(closed));
  SolverOptions o;
  o.method = method;
  o.end_time = 1.0;
  o.tolerance = 1e-5;
  if (o.method == "generalised_alpha") o.fixed_step = 2e-5;
  const auto integrator = make_integrator(start.m, o);
  integrator->start(start.s, start.v_dot);
  // The first steps find the sizes, and IDA its order.
  for (int k = 0; k < 20; ++k) integrator->step(o.end_time);
  const long jacobians = integrator->counts().jacobians, before = allocations;
  for (int k = 0; k < 60; ++k) integrator->step(o.end_time);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_GT(before, 0);
  if (o.method == "ida") {
    EXPECT_GT(integrator->counts().jacobians, jacobians);  // they were among these steps
  }
}

INSTANTIATE_TEST_SUITE_P(Integrators, Allocations,
                         ::testing::Values(std::pair("ida", true), std::pair("generalised_alpha", true),
                                           std::pair("radau", true), std::pair("runge_kutta", true),
                                           std::pair("runge_kutta", false)),
                         [](const auto& info) {
                           return std::string(info.param.first) + (info.param.second ? "_loop" : "_tree");
                         });

// n rods on hinges whose axes turn by 90 degrees from one to the next.
Mechanism chain(int n) {
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  int before = 0;
  for (int i = 0; i < n; ++i) {
    const int body = d.add_body({.name = "rod" + std::to_string(i),
                                 .inertia = RigidInertia::from_center(
                                     1.0, {0.5, 0.0, 0.0}, Vector3d(1e-4, 0.08, 0.08).asDiagonal())});
    Pose out, in;
    if (i > 0) out.p = {1.0, 0.0, 0.0};
    if (i % 2 == 1) out.R = in.R = rotation_exp({0.5 * M_PI, 0.0, 0.0});
    d.add_joint("hinge" + std::to_string(i), "revolute", d.add_marker(before, "out" + std::to_string(i), out),
                d.add_marker(body, "in", in));
    before = body;
  }
  return Mechanism(std::move(d));
}

TEST(Steps, OfAChainCostInProportionToItsLength) {
  double best[2] = {1e300, 1e300};
  const Mechanism chains[2] = {chain(40), chain(400)};
  for (int sample = 0; sample < 5; ++sample)
    for (int k = 0; k < 2; ++k) {
      SolverOptions o;
      o.method = "runge_kutta";
      o.fixed_step = 1e-3;
      State s = chains[k].initial_state();
      const Eigen::VectorXd v_dot = Eigen::VectorXd::Zero(chains[k].sizes().n_v);
      const auto integrator = make_integrator(chains[k], o);
      integrator->start(s, v_dot);
      integrator->step(o.end_time);
      const std::clock_t start = std::clock();  // processor time
      for (int i = 0; i < (k == 0 ? 50 : 5); ++i) integrator->step(o.end_time);
      best[k] = std::min(best[k], static_cast<double>(std::clock() - start) / (k == 0 ? 50 : 5));
    }
  // tests/benchmarks measures 1.05 over three sizes on a quiet machine; one step of n^2 work in a step makes
  // this 1.5 and more.
  EXPECT_LT(std::log10(best[1] / best[0]), 1.25);
}

}  // namespace
}  // namespace flexura::mbs::test
