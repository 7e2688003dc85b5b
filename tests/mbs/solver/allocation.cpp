// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "mbs/model/mechanism.hpp"
#include "mbs/model/modal_basis.hpp"
#include "mbs/solver/assemble.hpp"
#include "mbs/solver/integrator.hpp"
#include "tests/mbs/allocations.hpp"
#include "tests/mbs/model/lattice.hpp"

namespace flexura::mbs::test {
namespace {

// A crank, a flexible rod and a slider: a closed loop, modes, a spring.
MechanismDescription engine(bool closed) {
  const lattice::Lattice l = lattice::make_lattice(6, 4e4);
  const Vector3d left = l.se.interfaces[0].p_BoN_B, right = l.se.interfaces[1].p_BoN_B;
  const double length = (right - left).norm();
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  const int crank = d.add_body(
      {.name = "crank",
       .inertia = RigidInertia::from_center(1.0, {0.1 * length, 0, 0}, Matrix3d::Identity() * 0.1)});
  const int rod = d.add_body({.name = "rod", .flexible = std::make_shared<FlexibleBody>(modal_data(l.se))});
  const int slider =
      d.add_body({.name = "slider",
                  .inertia = RigidInertia::from_center(1.0, Vector3d::Zero(), Matrix3d::Identity() * 0.1)});
  Pose pin, along_x;
  pin.p = {0.3 * length, 0.0, 0.0};
  along_x.R.col(0) = Vector3d::UnitY();
  along_x.R.col(1) = Vector3d::UnitZ();
  along_x.R.col(2) = Vector3d::UnitX();
  const int shaft = d.add_joint("shaft", "revolute", d.add_marker(0, "shaft"), d.add_marker(crank, "shaft"));
  d.joints[shaft].initial_speeds[0] = 3.0;
  d.add_joint("pin", "revolute", d.add_marker(crank, "pin", pin), d.add_marker(rod, "left", {}, 0));
  d.add_joint("guide", "prismatic", d.add_marker(0, "guide", along_x),
              d.add_marker(slider, "guide", along_x));
  if (closed)
    d.joints[d.add_joint("wrist", "spherical", d.add_marker(rod, "right", {}, 1),
                         d.add_marker(slider, "wrist"))]
        .cut = true;
  return d;
}

class Steps : public ::testing::TestWithParam<const char*> {};

TEST_P(Steps, AllocateNothing) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer owns malloc";
#endif
  // The explicit integrator works in the coordinates of a tree.
  Mechanism m(engine(std::string(GetParam()) != "runge_kutta"));
  State s = m.initial_state();
  Eigen::VectorXd v_dot;
  assemble_positions(m, s);
  m.drop_redundant(0.0, s.p);
  s.lambda = Eigen::VectorXd::Zero(m.sizes().n_lambda);
  assemble(m, s, v_dot);
  SolverOptions o;
  o.method = GetParam();
  o.end_time = 1.0;
  o.tolerance = 1e-5;
  if (o.method == "generalised_alpha") o.fixed_step = 2e-5;
  const auto integrator = make_integrator(m, o);
  integrator->start(s, v_dot);
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

INSTANTIATE_TEST_SUITE_P(Integrators, Steps, ::testing::Values("ida", "generalised_alpha", "runge_kutta"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace flexura::mbs::test
