// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/statics/statics.hpp"
#include "tests/mbs/solver/planar.hpp"
#include "tests/mbs/solver/simple.hpp"

namespace flexura::mbs::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Statics, PendulumHangsDownFromAnywhere) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << std::cos(1.2), std::sin(1.2);  // above the pivot
  const StaticsReport r = solve_statics(m, s);
  EXPECT_NEAR(s.p(0), 0.0, 1e-9);
  EXPECT_NEAR(s.p(1), -1.0, 1e-12);
  EXPECT_NEAR(s.lambda(0), 9.81, 1e-8);  // the rod carries the weight: lambda p = (0, -m g)
  EXPECT_LT(r.constraint_residual, 1e-14);
}

TEST(Statics, NewtonAloneFindsTheUprightPendulum) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << std::cos(1.5), std::sin(1.5);
  s.lambda << -9.0;
  StaticsOptions o;
  o.stable = false;
  solve_statics(m, s, o);
  EXPECT_NEAR(s.p(1), 1.0, 1e-12);
  EXPECT_NEAR(s.lambda(0), -9.81, 1e-8);
}

TEST(Statics, SliderCrankOnASpringBalancesTheTorqueOfItsWeights) {
  PlanarMechanism m = slider_crank();
  m.gravity = {0.0, -9.81};
  m.springs.push_back({PlanarPoint().slide(m.unit({2}), 1, 0), {0.6, 0.0}, 500.0, 0.2, 0.0});
  State s = make_state(m);
  s.p << 0.8, -0.2, 0.35;
  solve_statics(m, s);
  // Virtual work over the crank angle: V'(a) = 0 with the closed-form position, by central differences.
  auto energy = [](double a) {
    const double b = -std::asin(0.1 * std::sin(a) / 0.3), x = 0.1 * std::cos(a) + 0.3 * std::cos(b);
    return 9.81 * (1.0 * 0.05 * std::sin(a) + 0.6 * (0.1 * std::sin(a) + 0.15 * std::sin(b))) +
           250.0 * std::pow(std::abs(x - 0.6) - 0.2, 2);
  };
  const double h = 1e-4;  // truncation h^2, round-off eps V / h
  const double curvature = (energy(s.p(0) + h) - 2 * energy(s.p(0)) + energy(s.p(0) - h)) / (h * h);
  EXPECT_NEAR((energy(s.p(0) + h) - energy(s.p(0) - h)) / (2 * h) / curvature, 0.0, 1e-7);
  EXPECT_GT(curvature, 0.0);
}

TEST(Statics, BodyThatNothingHoldsIsNamed) {
  BouncingBall m;
  m.g = -9.81;  // rises for ever, away from the floor
  State s = make_state(m);
  s.p << 1.0;
  try {
    solve_statics(m, s);
    FAIL() << "found an equilibrium";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("no equilibrium"), HasSubstr("\"v0\""), HasSubstr("4.905")));
  }
}

TEST(Linearise, ChainHasItsClosedFormFrequencies) {
  SpringChain m(6);
  m.damping = 0.4;  // proportional: zeta_k = omega_k d / (2 k)
  const State s = make_state(m);
  const auto modes = natural_modes(linearise(m, s));
  ASSERT_EQ(modes.size(), 6u);
  for (int k = 1; k <= 6; ++k) {
    const double omega = m.omega(k), zeta = 0.5 * omega * m.damping / m.stiffness;
    // The equations are linear: central differences are exact but for round-off, eps / 1e-5.
    EXPECT_NEAR(modes[k - 1].eigenvalue.real(), -zeta * omega, 1e-8 * omega);
    EXPECT_NEAR(modes[k - 1].eigenvalue.imag(), omega * std::sqrt(1 - zeta * zeta), 1e-8 * omega);
    EXPECT_NEAR(modes[k - 1].damping, zeta, 1e-8);
    // Shape sin(i k pi / 7).
    for (int i = 0; i < 6; ++i)
      EXPECT_NEAR(std::abs(modes[k - 1].shape(i)) * std::abs(std::sin(k * M_PI / 7)),
                  std::abs(std::sin((i + 1) * k * M_PI / 7)) * std::abs(modes[k - 1].shape(0)), 1e-7);
  }
}

TEST(Linearise, ConstrainedPendulumSwingsWithRootGOverLAndFallsFromTheTop) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << 0.0, -1.0;
  auto system = linearise(m, s);
  ASSERT_EQ(system.A.rows(), 2);
  EXPECT_EQ(system.states[0], "p0");  // x is the free coordinate, y follows
  EXPECT_EQ(system.states[1], "v0");
  auto modes = natural_modes(system);
  ASSERT_EQ(modes.size(), 1u);
  // Differences of 1e-5: truncation 1e-10, round-off 1e-11.
  EXPECT_NEAR(modes[0].eigenvalue.imag(), std::sqrt(9.81), 1e-8);
  EXPECT_NEAR(modes[0].eigenvalue.real(), 0.0, 1e-8);
  s.p << 0.0, 1.0;
  modes = natural_modes(linearise(m, s));
  ASSERT_EQ(modes.size(), 2u);
  EXPECT_NEAR(modes[0].eigenvalue.real(), -std::sqrt(9.81), 1e-8);
  EXPECT_NEAR(modes[1].eigenvalue.real(), std::sqrt(9.81), 1e-8);
}

TEST(Linearise, SpinningBodyHasItsNutationInCoordinatesThatMoveAlong) {
  // Axisymmetric top in space, spin Omega about its axis: perturbations of the transverse rates turn with
  // (J_a / J_t - 1) Omega in the body's frame.
  FreeBody m;
  m.inertia = {0.1, 0.1, 0.3};
  State s = make_state(m);
  s.p << 0, 0, 0, 0.8, 0.0, 0.6, 0.0;
  s.v << 1.0, 0.0, 0.0, 0.0, 0.0, 5.0;
  const auto modes = natural_modes(linearise(m, s));
  double nearest = 1.0, spin = 1.0;
  for (const auto& mode : modes) {
    nearest = std::min(nearest, std::abs(mode.eigenvalue - std::complex<double>(0.0, 10.0)));
    // The attitude itself turns with the spin in the body's frame.
    spin = std::min(spin, std::abs(mode.eigenvalue - std::complex<double>(0.0, 5.0)));
  }
  EXPECT_LT(nearest, 1e-7);
  EXPECT_LT(spin, 1e-7);
}

TEST(Linearise, FrequencyResponseIsThatOfTheDampedOscillator) {
  SpringChain m(1);  // one mass between two springs: k = 600, d = 2 * 0.4
  m.damping = 0.4;
  const State s = make_state(m);
  LineariseOptions o;
  o.inputs = {0};
  o.output_names = {"position", "acceleration"};
  o.outputs = [](const State& state, const Eigen::VectorXd& v_dot) {
    return Eigen::Vector2d(state.p(0), v_dot(0));
  };
  const LinearSystem system = linearise(m, s, o);
  EXPECT_EQ(system.inputs[0], "force on v0");
  const Eigen::Vector3d f(0.0, 4.0, 30.0);
  const auto H = frequency_response(system, f);
  for (int i = 0; i < 3; ++i) {
    const std::complex<double> iw(0.0, 2 * M_PI * f(i));
    const auto exact = 1.0 / (0.7 * iw * iw + 0.8 * iw + 600.0);
    EXPECT_LT(std::abs(H[i](0, 0) - exact), 1e-8 * std::abs(exact));
    EXPECT_LT(std::abs(H[i](1, 0) - iw * iw * exact), 1e-8 * (1.0 / 0.7));
  }
}

}  // namespace
}  // namespace flexura::mbs::test
