// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The Laval rotor of cases/rotor run up through its critical speed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using Complex = std::complex<double>;

/// Jeffcott's rotor in space axes, driven to the angle phi(t) (H. H. Jeffcott, Phil. Mag. 37 (1919) 304):
///
///     z'' + 2 D w z' + w^2 z = u (phi'^2 - i phi'') exp(i phi)
struct Jeffcott {
  double w, D, u, alpha, top;
  struct Angle {
    double phi, rate, rise;
  };
  Angle angle(double t) const {
    if (t < top / alpha) return {0.5 * alpha * t * t, alpha * t, alpha};
    return {top * t - 0.5 * top * top / alpha, top, 0.0};
  }
  Complex acceleration(double t, Complex z, Complex v) const {
    const auto [phi, rate, rise] = angle(t);
    return u * Complex(rate * rate, -rise) * std::polar(1.0, phi) - 2.0 * D * w * v - w * w * z;
  }
  /// |z| every `dt`, from the quasi-static start, by the classical Runge-Kutta method: 250 steps to the
  /// period of the critical speed leave (2 pi / 250)^4 / 120 of a radian each, 1e-7 in the end.
  std::vector<double> deflection(double dt, int rows) const {
    const int n = 10;
    const double h = dt / n;
    Complex z = u * Complex(0.0, -alpha) / (w * w), v = 0.0;
    std::vector<double> out;
    for (int k = 0; k <= n * (rows - 1); ++k) {
      if (k % n == 0) out.push_back(std::abs(z));
      const double t = k * h;
      const Complex a_1 = acceleration(t, z, v), v_2 = v + 0.5 * h * a_1;
      const Complex a_2 = acceleration(t + 0.5 * h, z + 0.5 * h * v, v_2), v_3 = v + 0.5 * h * a_2;
      const Complex a_3 = acceleration(t + 0.5 * h, z + 0.5 * h * v_2, v_3), v_4 = v + h * a_3;
      const Complex a_4 = acceleration(t + h, z + h * v_3, v_4);
      z += h / 6.0 * (v + 2.0 * v_2 + 2.0 * v_3 + v_4);
      v += h / 6.0 * (a_1 + 2.0 * a_2 + 2.0 * a_3 + a_4);
    }
    return out;
  }
};

TEST(LavalRotor, RunsUpThroughItsCriticalSpeedAsJeffcottsEquation) {
  const Folder folder;
  const std::filesystem::path rotor = std::filesystem::path(FLEXURA_SOURCE_DIR) / "cases/rotor";
  const std::string se = folder / "laval.se.h5", output = folder / "run_up.h5";
  const Outcome reduced = run("flexura", {"reduce", rotor / "laval.toml", "-q", "-o", se});
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  const Outcome simulated = run("flexura", {"simulate", rotor / "run_up.toml", "-q", "--no-estimate", "-o",
                                            output, "--set", "body.shaft.superelement=" + se});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const results::Results results = results::read(output);
  const results::Run& history = results.runs.at(0);
  Eigen::VectorXd found;
  for (std::size_t j = 0; j < history.quantities.size(); ++j)
    if (history.quantities[j].name == "deflection") found = history.values.col(static_cast<Eigen::Index>(j));
  ASSERT_EQ(found.size(), 1701);

  // A shaft clamped in both bearings: k = 192 EI / L^3, and 13/35 of its mass beside the disc's (the static
  // shape; Rayleigh's quotient errs with the square of the mass ratio, 4 %).
  const double r = 0.01, EI = 210e9 * M_PI * std::pow(r, 4) / 4.0, disc = 20.0,
               m = disc + 13.0 / 35.0 * 7850.0 * M_PI * r * r;
  Jeffcott exact{
      .w = std::sqrt(192.0 * EI / m), .D = 0.0, .u = 20e-6 * disc / m, .alpha = 75.0, .top = 250.0};
  exact.D = 150.0 / m / (2.0 * exact.w);
  const std::vector<double> expected = exact.deflection(0.002, 1701);
  const double peak = *std::max_element(expected.begin(), expected.end());
  // Quasi-static modes above 2.5 kHz and the disc's twist against the drive, alpha / w_t^2 = 0.012 rad, move
  // the curve by less than 1 % of its peak.
  double worst = 0.0;
  for (int k = 0; k < 1701; ++k) worst = std::max(worst, std::abs(found(k) - expected[k]));
  EXPECT_LT(worst, 0.01 * peak);
  EXPECT_NEAR(found.maxCoeff(), peak, 0.01 * peak);
  // A fast run-up stays below the stationary resonance u / (2 D) and meets its peak late.
  EXPECT_LT(found.maxCoeff(), 0.75 * exact.u / (2.0 * exact.D));
  Eigen::Index at;
  found.maxCoeff(&at);
  EXPECT_GT(75.0 * 0.002 * static_cast<double>(at), 1.1 * exact.w);
}

}  // namespace
}  // namespace flexura::test
