// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

/// Rotors: a light elastic shaft, clamped to a driven spindle, with a disc on its free end.
namespace flexura::mbs {
namespace {

constexpr double mass = 2.0, theta_p = 0.06, theta_d = 0.035, L = 0.5, EI = 300.0;

/// `eccentricity` of the disc's centre along the shaft's y.
Mechanism overhung_rotor(double Omega, double eccentricity = 0.0) {
  beams::StraightBeam shaft;
  shaft.length = L;
  shaft.elements = 6;
  shaft.EA = 1e7;
  shaft.GI_t = 1e5;  // no stretch and twist among the four lowest
  shaft.EI_y = shaft.EI_z = EI;
  shaft.mass_per_length = 1e-4;  // 2.5e-5 of the disc's mass
  shaft.rho_I_y = shaft.rho_I_z = 1e-8;
  const superelement::Superelement se = beams::beam_superelement(shaft);
  BasisOptions options;
  options.held = interface_loads(se, 0);
  options.fixed_interface = 0;
  options.modes = 0;
  // The disc's loads with what holds them at the root: the static deformations of a shaft without mass.
  options.loads = interface_loads(se, 1) - interface_loads(se, 0, {L, 0.0, 0.0});
  options.damping = 0.0;
  MechanismDescription d;
  const int beam =
      d.add_body({.name = "shaft", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
  const Pose along_x{frame_along(Vector3d::UnitX()), Vector3d::Zero()};
  const int spindle = d.add_joint("spindle", "revolute", d.add_marker(0, "bearing", along_x),
                                  d.add_marker(beam, "root", along_x, 0));
  d.joints[spindle].drives[0] = std::make_shared<Expression>("spindle", "W * t", SignalNames(),
                                                             std::map<std::string, double>{{"W", Omega}});
  const Matrix3d inertia = Vector3d(theta_p, theta_d, theta_d).asDiagonal();
  const int disc = d.add_body(
      {.name = "disc", .inertia = RigidInertia::from_center(mass, {0.0, eccentricity, 0.0}, inertia)});
  d.add_joint("hub", "fixed", d.add_marker(beam, "tip", {}, 1), d.add_marker(disc, "in"));
  return Mechanism(d);
}

State spinning(Mechanism& mechanism) {
  State s = mechanism.initial_state();
  Eigen::VectorXd v_dot;
  assemble(mechanism, s, v_dot);
  return s;
}

/// Whirl speeds in space of the overhung disc on a massless shaft (R. Gasch, R. Nordmann, H. Pfuetzner,
/// Rotordynamik, ch. 5): with z = r + i s and the complex tilt, both proportional to exp(i w t),
///
///     [ k_11 - m w^2        k_12                              ]
///     [ k_12                k_22 - Theta_d w^2 + Theta_p Omega w ]   singular;  k = EI/L^3 (12, -6 L, 4
///     L^2).
///
/// Four real roots; w > 0 forward, w < 0 backward whirl.
std::vector<double> whirl_speeds(double Omega) {
  const double k_11 = 12 * EI / (L * L * L), k_12 = -6 * EI / (L * L), k_22 = 4 * EI / L;
  // (k_11 - m w^2)(k_22 + Theta_p Omega w - Theta_d w^2) - k_12^2 = 0, by the companion matrix.
  const double a_4 = mass * theta_d, a_3 = -mass * theta_p * Omega, a_2 = -k_11 * theta_d - mass * k_22,
               a_1 = k_11 * theta_p * Omega, a_0 = k_11 * k_22 - k_12 * k_12;
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  companion.row(0) << -a_3 / a_4, -a_2 / a_4, -a_1 / a_4, -a_0 / a_4;
  companion(1, 0) = companion(2, 1) = companion(3, 2) = 1.0;
  std::vector<double> w;
  for (const std::complex<double>& root : companion.eigenvalues()) w.push_back(root.real());
  std::sort(w.begin(), w.end());
  return w;
}

TEST(OverhungRotor, WhirlSpeedsSplitGyroscopically) {
  for (const double Omega : {0.0, 40.0, 150.0, 400.0}) {
    SCOPED_TRACE(Omega);
    Mechanism mechanism = overhung_rotor(Omega);
    const State s = spinning(mechanism);
    // The modal coordinates turn with the shaft, which sees the whirl w as |w - Omega|.
    std::vector<double> expected, found;
    for (const double w : whirl_speeds(Omega)) expected.push_back(std::abs(w - Omega));
    std::sort(expected.begin(), expected.end());
    for (const NaturalMode& mode : natural_modes(linearise(mechanism, s)))
      found.push_back(mode.eigenvalue.imag());
    std::sort(found.begin(), found.end());
    ASSERT_GE(found.size(), 4u);
    // Shaft mass 2.5e-5 of the disc's, a quarter of it on the tip, half that in w; differences leave 1e-9 of
    // A's scale, (3e3)^2 of the shaft's stretch, in w^2: 1e-5 of the lowest w.
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(found[k], expected[k], 5e-5 * (expected[k] + Omega));
  }
}

TEST(OverhungRotor, UnbalanceResponseHasTheClosedFormBelowAndAboveTheCriticalSpeed) {
  // In the shaft's frame the response to unbalance is at rest: (K - Omega^2 M) (r, tilt) = Omega^2 m e, with
  // Theta_d - Theta_p in place of Theta_d (synchronous whirl).
  const double e = 1e-5;
  double below = 0.0, above = 0.0;
  for (const double Omega : {20.0, 45.0, 90.0, 300.0}) {
    SCOPED_TRACE(Omega);
    Eigen::Matrix2d K;
    K << 12 * EI / (L * L * L), -6 * EI / (L * L), -6 * EI / (L * L), 4 * EI / L;
    K(0, 0) -= mass * Omega * Omega;
    K(1, 1) -= (theta_d - theta_p) * Omega * Omega;
    const Eigen::Vector2d r = K.inverse() * Eigen::Vector2d(mass * e * Omega * Omega, 0.0);
    (Omega < 63.0 ? below : above) = r(0);

    Mechanism mechanism = overhung_rotor(Omega, e);
    State s = spinning(mechanism);
    // Relative equilibrium by Newton's method on the modal rows.
    const int n = mechanism.sizes().n_flx, at_p = mechanism.modal_position(1),
              at_v = mechanism.sizes().n_v - n;
    const auto scratch = mechanism.make_scratch();
    const auto residual = [&](const State& state) {
      Eigen::VectorXd out(mechanism.sizes().n_v), none(0), b(0);
      mechanism.momentum(state, Eigen::VectorXd::Zero(out.size()), *scratch, out, none, b);
      return Eigen::VectorXd(out.tail(n));
    };
    ASSERT_EQ(at_v, 1);
    s.v.tail(n).setZero();
    s.p.tail(n).setZero();
    for (int iteration = 0; iteration < 6; ++iteration) {
      Eigen::MatrixXd J(n, n);
      for (int k = 0; k < n; ++k) {
        State up = s, down = s;
        const double h = 1e-6 * mechanism.position_scale(at_p + k);
        up.p(at_p + k) += h;
        down.p(at_p + k) -= h;
        J.col(k) = (residual(up) - residual(down)) / (2 * h);
      }
      s.p.tail(n) -= J.fullPivLu().solve(residual(s));
    }
    const FlexibleBody& body = *mechanism.description().bodies[1].flexible;
    const Vector3d tip = body.node_pose(1, s.p.data() + at_p).p;
    // The critical speed is 63.5 1/s.  Rotations of order e/L = 2e-5 enter squared; the shaft has 2.5e-5 of
    // the mass, magnified twice at 45 1/s.
    EXPECT_NEAR(tip.y(), r(0), 5e-4 * std::abs(r(0)));
    EXPECT_NEAR(tip.z(), 0.0, 1e-9);
  }
  EXPECT_GT(below, 0.0);  // outwards
  EXPECT_LT(above, 0.0);  // self-centring
}

}  // namespace
}  // namespace flexura::mbs
