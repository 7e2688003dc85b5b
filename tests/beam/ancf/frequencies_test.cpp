// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/frequencies.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "beam/ancf/ancf_statics.hpp"
#include "tests/beam/ancf/samples.hpp"

namespace flexura::beam::ancf {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// omega of the lowest vibration whose largest coordinate moves along `axis`.
double lowest_along(const AncfBody& body, const Vibrations& vibrations, int axis) {
  for (int k = 0; k < vibrations.s.size(); ++k) {
    Eigen::Index largest;
    vibrations.modes.col(k).cwiseAbs().maxCoeff(&largest);
    if (largest % body.dim() == axis && vibrations.s[k].imag() > 0) return vibrations.s[k].imag();
  }
  return NAN;
}

TEST(AncfVibrations, CantileverHasTheEulerBernoulliFrequencies) {
  // (beta L)^2 = 3.51602, 22.0345, 61.6972, printed to 2e-6.  Cubic elements with consistent mass
  // overestimate omega by (beta l)^4/1440 (leading term; a fifth more for the next).
  const int n = 8;
  const LineSection section{.EA = 1e6, .EI = 1, .mass_per_length = 1};
  const AncfBody body = planar_line(section, straight_curve({0, 0, 0}, {1, 0, 0}, n));
  const auto result = vibrations(held(body, clamp_of_line(2)), body.rest(), VectorXd(), 10.0);
  const double exact[] = {3.51602, 22.0345, 61.6972};
  for (int k = 0; k < 3; ++k) {
    const double beta_l_4 = exact[k] * exact[k] / std::pow(n, 4);
    EXPECT_NEAR(result.s[k].imag(), exact[k], (1.2 * beta_l_4 / 1440 + 2e-6) * exact[k]) << k;
    EXPECT_NEAR(result.s[k].real(), 0.0, 1e-9 * exact[k]) << k;
  }
}

TEST(AncfVibrations, KelvinVoigtDampingRatioGrowsWithFrequency) {
  // Stress E (eps + tau eps_dot): s^2 + tau omega^2 s + omega^2 = 0, so Re s = -tau omega^2/2 exactly, |s| =
  // omega.
  const double tau = 1e-3;
  const LineSection section{
      .EA = 1e6, .EI = 1, .mass_per_length = 1, .damping_time_axial = tau, .damping_time_bending = tau};
  for (const AncfBody& body : {planar_line(section, straight_curve({0, 0, 0}, {1, 0, 0}, 4)),
                               spatial_line(section, straight_curve({0, 0, 0}, {1, 0, 0}, 4))}) {
    const auto result = vibrations(held(body, clamp_of_line(body.dim())), body.rest(), VectorXd(), 10.0);
    for (int k = 0; k < 3; ++k) {
      const double omega2 = std::norm(result.s[k]);
      // Round-off of the eigensolver at the lowest modes.
      EXPECT_NEAR(result.s[k].real(), -0.5 * tau * omega2, 1e-8 * std::sqrt(omega2)) << k;
    }
  }
}

TEST(AncfVibrations, RotatingCantileverStiffens) {
  // Slenderness L sqrt(A/I) = 70; mu = Omega sqrt(rho A L^4/EI): published first flapwise and chordwise
  // frequencies (S. M. Hamza-Cherif, M. S. A. Houmat, ICAS 2004).
  const double table[][3] = {
      {2, 4.1373, 3.6195}, {4, 5.5850, 3.888}, {6, 7.3603, 4.2393}, {8, 9.2568, 4.6105}, {10, 11.2023, 4.97}};
  const double EA = 4900, GA = EA * 5 / 6 / 2.6;
  const auto curve = [](int n) { return straight_curve({0, 0, 0}, {1, 0, 0}, n); };
  std::vector<std::tuple<std::string, AncfBody, std::vector<int>>> bodies;
  const LineSection line{.EA = EA, .EI = 1, .mass_per_length = 1};
  bodies.emplace_back("planar line", planar_line(line, curve(8)), clamp_of_line(2));
  bodies.emplace_back("spatial line", spatial_line(line, curve(8)), clamp_of_line(3));
  // A beam's curvature is constant in an element (order 2), and the chordwise frequency, whose square is a
  // difference of squares, magnifies errors by (flap/chord)^2 = 5 at mu = 10.
  bodies.emplace_back("spatial beam",
                      spatial_beam(uncoupled_section(EA, GA, GA, 0.8, 1, 1, 1, 1 / EA, 1 / EA), curve(12)),
                      kBeamClamp);
  for (const auto& [name, body, fixed] : bodies)
    for (const auto& [mu, flap, chord] : table) {
      Problem problem = held(body, fixed);
      problem.spin = Vector3d(0, 0, mu);
      const auto steady = solve_static(problem, body.rest());
      const auto result = vibrations(problem, steady.q, steady.lambda, 5.0);
      // 1 %: linear theory against finite axial strain, mu^2/(2 EA) = 1 % at mu = 10.
      EXPECT_NEAR(lowest_along(body, result, 1), chord, 0.01 * chord) << name << " " << mu;
      if (body.dim() == 3) {
        EXPECT_NEAR(lowest_along(body, result, 2), flap, 0.01 * flap) << name << " " << mu;
      }
    }
}

TEST(AncfVibrations, TautStringSings) {
  // f_n = n/(2L) sqrt(F/mu), L and mu of the stretched string.  Order 4: relative error below (k
  // pi/n)^4/1440.
  const double L_0 = 1, L = 1.02, EA = 500, mu_0 = 0.3, F = EA * (L / L_0 - 1), mu = mu_0 * L_0 / L;
  const LineSection section{.EA = EA, .EI = 0, .mass_per_length = mu_0};
  for (const int n : {8, 16}) {
    const AncfBody body = spatial_line(section, straight_curve({0, 0, 0}, {L_0, 0, 0}, n));
    const int end = body.index(n, 0);
    const Problem problem = held(body, {0, 1, 2, end, end + 1, end + 2});
    VectorXd q = body.rest();
    for (int i = 0; i < body.n_q(); i += 3) q[i] *= L;
    const auto result = vibrations(problem, q, VectorXd(), 20.0);
    for (int k = 1; k <= 3; ++k) {
      const double exact = 2 * M_PI * k / (2 * L) * std::sqrt(F / mu);
      for (const int i : {2 * k - 2, 2 * k - 1})  // in y and in z
        EXPECT_NEAR(result.s[i].imag() / exact, 1.0, std::pow(k * M_PI / n, 4) / 1440) << n << " " << k;
    }
  }
}

}  // namespace
}  // namespace flexura::beam::ancf
