// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "lumped_bar.hpp"  // as it stands in docs/architecture.md
#include "mbs/mechanism/mechanism.hpp"
#include "tests/mbs/model/checks.hpp"

/// A fidelity with nothing but what is pure in FlexibleBody: the base's own derivatives carry it.
namespace flexura::mbs {
namespace {

using Eigen::VectorXd;

std::shared_ptr<const FlexibleBody> bar(const Vector3d& root, const Vector3d& tip, double mass,
                                        double stiffness) {
  return std::make_shared<const LumpedBar>(
      std::vector<NodePlace>{{"root", root}, {"tip", tip}, {"middle", 0.5 * (root + tip)}}, mass, stiffness);
}

TEST(SampleFidelity, IdentitiesOfMechanicsHold) {
  checks::Random random(5);
  MechanismDescription d;
  d.gravity = {0.3, -9.0, 1.0};
  const int carrier = d.add_body({.name = "carrier", .inertia = random.inertia()});
  d.add_joint("base", "revolute", d.add_marker(0, "o"), d.add_marker(carrier, "o", random.pose()));
  const int body = d.add_body({.name = "bar", .flexible = bar({0.1, 0.2, -0.1}, {1.0, 0.4, 0.3}, 1.3, 40.0)});
  d.add_joint("root", "revolute", d.add_marker(carrier, "hand", random.pose()),
              d.add_marker(body, "root", random.pose(), 0));
  const int weight = d.add_body({.name = "weight", .inertia = random.inertia()});
  d.add_joint("tip", "prismatic", d.add_marker(body, "tip", random.pose(), 1),
              d.add_marker(weight, "in", random.pose()));
  const Mechanism mechanism(d);
  checks::all_identities_hold(mechanism, 7);
  checks::lagrange_equations_hold(mechanism, checks::random_state(mechanism, 9, 0.3), 11);
}

// Half the mass on a spring, k / (m / 2) = omega^2, and at rest stretched by its tip's weight, m g / (2 k).
TEST(SampleFidelity, HangsAndSwingsAsASpringWithHalfTheMass) {
  const double m = 3.0, k = 700.0, g = 9.81;
  MechanismDescription d;
  d.gravity = {0.0, 0.0, -g};
  const int body = d.add_body({.name = "bar", .flexible = bar(Vector3d::Zero(), {0.0, 0.0, -2.0}, m, k)});
  d.add_joint("clamp", "fixed", d.add_marker(0, "o"), d.add_marker(body, "root", {}, 0));
  const Mechanism mechanism(d);
  ASSERT_EQ(mechanism.sizes().n_v, 1);
  State s = mechanism.initial_state();
  s.p(0) = 0.5 * m * g / k;
  const auto scratch = mechanism.make_scratch();
  VectorXd r(1), c_rate(0), b(0), v_dot = VectorXd::Zero(1);
  mechanism.momentum(s, v_dot, *scratch, r, c_rate, b);
  EXPECT_NEAR(r(0), 0.0, 1e-12 * m * g);  // round-off
  Eigen::MatrixXd M(1, 1);
  mechanism.mass_matrix(s.p, *scratch, M);
  EXPECT_DOUBLE_EQ(M(0, 0), 0.5 * m);
  TangentMatrices t;
  t.z_p.setZero(1, 1);
  t.z_v.setZero(1, 1);
  t.z_c.setZero(1, 0);
  t.z_a.setZero(1, 0);
  t.h_p.setZero(0, 1);
  ASSERT_TRUE(mechanism.tangents(s, v_dot, TangentScope::everything, *scratch, t));
  // Central differences of a linear function: round-off over the step, 1e-10 of what is differenced.
  EXPECT_NEAR(t.z_p(0, 0), k, 1e-8 * k);
}

}  // namespace
}  // namespace flexura::mbs
