// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <numbers>

#include "tests/mbs/cases/text_case.hpp"
#include "tests/reference.hpp"

/// Journal bearings: Ocvirk's load, published linear coefficients, the integral of the pressure, oil whirl.
namespace flexura::mbs::cases {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using ::testing::HasSubstr;
constexpr double pi = std::numbers::pi;

constexpr double R = 0.03, L = 0.02, c = 1e-4, mu = 0.02;

class JournalBearings : public TextCase {
 protected:
  struct Film {
    Vector2d force;
    double torque, eccentricity, lost;
  };
  /// The journal at d, moving with v and turning with omega.
  Film film(const Vector2d& d, const Vector2d& v, double omega, const std::string& keys = "") const {
    const Eigen::VectorXd x = now(
        prepared(fmt::format(
            "gravity = [0, 0, 0]\n[body.shaft]\nmass = 1\ninertia = [1, 1, 1]\nposition = "
            "[{:.17g}, {:.17g}, 0]\nvelocity = [{:.17g}, {:.17g}, 0]\nangular_velocity = [0, 0, {:.17g}]\n"
            "[force.b]\ntype = \"journal_bearing\"\nfrom = \"ground\"\nto = \"shaft\"\nradius = {}\n"
            "length = {}\nclearance = {}\nviscosity = {}\n{}\n{}",
            d.x(), d.y(), v.x(), v.y(), omega, R, L, c, mu, keys, solver)),
        {"b.force_x", "b.force_y", "b.torque_z", "b.eccentricity", "b.power_lost"});
    return {x.head<2>(), x(2), x(3), x(4)};
  }
};

constexpr flexura::test::Reference ocvirk{
    "Short journal bearing, closed form (Ocvirk, NACA TN 2808, 1952; Petroff)",
    "round-off of the film's place, 1e-9 of the force"};

TEST_F(JournalBearings, LoadIsOcvirks) {
  // F. W. Ocvirk, NACA TN 2808 (1952): with half of the film, in units of mu R L^3 omega / c^2, back to the centre
  // e^2 / (1 - e^2)^2 and across, the way it turns, pi e / (4 (1 - e^2)^(3/2)).
  const double omega = 300.0, unit = mu * R * L * L * L * omega / (c * c);
  for (const double e : {0.1, 0.5, 0.9}) {
    const Film at = film({e * c, 0.0}, Vector2d::Zero(), omega);
    const double s = 1.0 - e * e;
    const std::string where = fmt::format(", eccentricity {}", e);
    flexura::test::expect_reference("force back to the centre" + where, "N", at.force.x(),
                                    -unit * e * e / (s * s), 1e-9 * unit / (s * s), ocvirk);
    flexura::test::expect_reference("force across" + where, "N", at.force.y(),
                                    unit * pi * e / (4 * std::pow(s, 1.5)), 1e-9 * unit / (s * s), ocvirk);
    EXPECT_NEAR(at.eccentricity, e, 1e-12);
  }
  // Petroff: a journal in the centre is held back by 2 pi mu R^3 L omega / c.
  flexura::test::expect_reference("torque of a journal in the centre", "N*m",
                                  film(Vector2d::Zero(), Vector2d::Zero(), omega).torque,
                                  -2 * pi * mu * R * R * R * L * omega / c, 1e-9, ocvirk);
}

TEST_F(JournalBearings, ForceIsTheIntegralOfThePressure) {
  const Vector2d d(0.4 * c, -0.5 * c), v(0.02, 0.013);
  const double omega = 250.0;
  for (const bool is_full : {false, true}) {
    const Film at = film(d, v, omega, is_full ? "film = \"full\"" : "");
    const Vector2d u = v + 0.5 * omega * Vector2d(d.y(), -d.x());
    const double middle = std::atan2(u.y(), u.x());
    Vector2d force = Vector2d::Zero();
    double shear = 0.0, squeezed = 0.0;
    const int n = 20000;  // Simpson's rule
    for (int i = 0; i <= n; ++i) {
      const double weight = (i == 0 || i == n ? 1.0 : i % 2 ? 4.0 : 2.0) / 3.0 / n;
      const double part = is_full ? 2 * pi : pi, angle = middle - 0.5 * part + part * i / n,
                   all = 2 * pi * i / n;
      const Vector2d e(std::cos(angle), std::sin(angle));
      const double P = mu * L * L * L * u.dot(e) / std::pow(c - d.dot(e), 3);
      force -= weight * part * P * R * e;
      squeezed += weight * part * P * R * u.dot(e);
      shear +=
          weight * 2 * pi * mu * R * R * R * L * omega / (c - d.x() * std::cos(all) - d.y() * std::sin(all));
    }
    EXPECT_LT((at.force - force).norm(), 1e-9 * force.norm());
    EXPECT_NEAR(at.torque, -0.5 * (d.x() * force.y() - d.y() * force.x()) - shear, 1e-9 * shear);
    EXPECT_NEAR(at.lost, squeezed + shear * omega, 1e-9 * at.lost);
    // What goes in comes out: the power of force and torque.
    EXPECT_NEAR(at.force.dot(v) + at.torque * omega, -at.lost, 1e-9 * at.lost);
  }
}

/// Coefficients of the short bearing (e.g. Y. Hori, Hydrodynamic Lubrication, Springer 2006, 5.2; E. Kraemer, Dynamics of
/// Rotors and Foundations, 1993), y along the load, x across it against the turning: K c / W and C c omega / W.
struct Coefficients {
  explicit Coefficients(double e) {
    const double p = pi * pi, Q = 1.0 / std::pow(p + (16 - p) * e * e, 1.5), r = std::sqrt(1 - e * e);
    K << 4 * (2 * p + (16 - p) * e * e) * Q,
        pi * (-p + 2 * p * e * e + (16 - p) * std::pow(e, 4)) * Q / (e * r),
        pi * (p + (32 + p) * e * e + 2 * (16 - p) * std::pow(e, 4)) * Q / (e * r),
        4 * (p + (32 + p) * e * e + 2 * (16 - p) * std::pow(e, 4)) * Q / (r * r);
    C << 2 * pi * r * (p + 2 * (p - 8) * e * e) * Q / e, 8 * (p + 2 * (p - 8) * e * e) * Q,
        8 * (p + 2 * (p - 8) * e * e) * Q,
        2 * pi * (p + 2 * (24 - p) * e * e + p * std::pow(e, 4)) * Q / (e * r);
  }
  /// omega sqrt(c / g) of a rigid rotor's threshold of stability, and how fast it then whirls over how fast it turns, by
  /// Routh's condition.
  std::pair<double, double> threshold() const {
    const double k =
        (K(0, 0) * C(1, 1) + K(1, 1) * C(0, 0) - K(0, 1) * C(1, 0) - K(1, 0) * C(0, 1)) / C.trace();
    const double whirl2 = ((K(0, 0) - k) * (K(1, 1) - k) - K(0, 1) * K(1, 0)) / C.determinant();
    return {std::sqrt(k / whirl2), std::sqrt(whirl2)};
  }
  Matrix2d K, C;
};

TEST_F(JournalBearings, CoefficientsAreThePublishedOnes) {
  const double omega = 300.0;
  for (const double e : {0.2, 0.5, 0.8}) {
    const Vector2d d(e * c, 0.0);
    const Vector2d f = film(d, Vector2d::Zero(), omega).force;
    const double W = f.norm();
    Matrix2d axes;  // columns x, y
    axes.col(1) = -f / W;
    axes.col(0) = Vector2d(-axes(1, 1), axes(0, 1));
    Matrix2d K, C;
    // Central differences: round-off 1e-16 / 1e-6, truncation 1e-12 times third derivatives of some thousands.
    const double h = 1e-6;
    for (int j = 0; j < 2; ++j) {
      const Vector2d q = h * c * axes.col(j), v = h * c * omega * axes.col(j), none = Vector2d::Zero();
      K.col(j) =
          -axes.transpose() * (film(d + q, none, omega).force - film(d - q, none, omega).force) / (2 * h * W);
      C.col(j) = -axes.transpose() * (film(d, v, omega).force - film(d, -v, omega).force) / (2 * h * W);
    }
    const Coefficients published(e);
    EXPECT_LT((K - published.K).norm(), 1e-6 * published.K.norm()) << e << "\n" << K << "\n" << published.K;
    EXPECT_LT((C - published.C).norm(), 1e-6 * published.C.norm()) << e << "\n" << C << "\n" << published.C;
  }
}

TEST_F(JournalBearings, RigidRotorWhirlsFromItsPublishedSpeedOn) {
  // A rotor on two bearings with an eccentricity of 0.3 at the threshold: there it turns with 2.606 sqrt(g / c) and whirls
  // with 0.519 of that; bearings with more than 0.756 are stable at any speed.
  const auto [speed, whirl] = Coefficients(0.3).threshold();
  EXPECT_NEAR(speed, 2.606, 1e-3);
  EXPECT_NEAR(whirl, 0.519, 1e-3);
  EXPECT_GT(Coefficients(0.755).threshold().first, 15.0);
  EXPECT_TRUE(std::isnan(Coefficients(0.757).threshold().first));
  const double g = 9.81, omega_s = speed * std::sqrt(g / c), e = 0.3, s = 1 - e * e;
  const double load =
      mu * R * L * L * L * omega_s / (c * c) * e * std::sqrt(16 * e * e + pi * pi * s) / (4 * s * s);
  const double mass = 2.0 * load / g;
  const auto amplitudes = [&](double omega) {
    // At rest in the eccentricity that belongs to this speed and load, by bisection, and a push of some per cent of c.
    double low = 0.0, high = 0.99;
    for (int i = 0; i < 100; ++i) {
      const double m = 0.5 * (low + high), q = 1 - m * m;
      (m * std::sqrt(16 * m * m + pi * pi * q) / (4 * q * q) * mu * R * L * L * L * omega / (c * c) < load
           ? low
           : high) = m;
    }
    const double q = 1 - low * low,
                 attitude = std::atan2(pi * std::sqrt(q), 4 * low);  // from the load, the way it turns
    const Vector2d rest = low * c * Vector2d(std::sin(attitude), -std::cos(attitude));
    std::string text = fmt::format(
        "gravity = [0, -{}, 0]\n[body.rotor]\nmass = {:.17g}\ninertia = [2, 2, 2]\nposition = "
        "[{:.17g}, {:.17g}, 0]\nangular_velocity = [0, 0, {:.17g}]\n",
        g, mass, rest.x() + 0.01 * c, rest.y(), omega);
    for (const double z : {-0.2, 0.2})
      text += fmt::format(
          "[ground.marker.{0}]\nposition = [0, 0, {1}]\n[body.rotor.marker.{0}]\nposition = [0, 0, {1}]\n"
          "[force.{0}]\ntype = \"journal_bearing\"\nfrom = \"ground.{0}\"\nto = \"rotor.{0}\"\nradius = {2}\n"
          "length = {3}\nclearance = {4}\nviscosity = {5}\n",
          z < 0 ? "left" : "right", z, R, L, c, mu);
    const double period = 2 * pi / (whirl * omega);
    const PreparedMechanism p =
        prepared(text + fmt::format("[solver]\nend_time = {:.17g}\noutput_step = {:.17g}\ntolerance = 1e-7\n",
                                    30 * period, period / 40));
    const Series run = simulate(p, {"rotor.position_x", "rotor.position_y"});
    EXPECT_LT(std::abs(run.result.energy.error()), 1e-3 * run.result.energy.dissipated);
    std::array<double, 2> largest{};
    int crossings = 0;
    for (std::size_t i = 0; i < run.t.size(); ++i) {
      const Vector2d off = run.values[i] - rest;
      if (run.t[i] > 5 * period && run.t[i] <= 10 * period) largest[0] = std::max(largest[0], off.norm());
      if (run.t[i] > 25 * period) largest[1] = std::max(largest[1], off.norm());
      if (i > 0 && off.x() > 0.0 && run.values[i - 1](0) - rest.x() <= 0.0) ++crossings;
    }
    return std::pair(largest[1] / largest[0], crossings);
  };
  EXPECT_LT(amplitudes(0.93 * omega_s).first, 0.7);
  const auto [growth, turns] = amplitudes(1.07 * omega_s);
  EXPECT_GT(growth, 1.4);
  EXPECT_NEAR(turns, 30, 2);  // of the whirl
}

TEST_F(JournalBearings, RefuseWhatCannotBe) {
  const Vector2d none = Vector2d::Zero();
  EXPECT_THAT(test::refusal_of([&] {
                film({1.1 * c, 0.0}, none, 100.0);
              }),
              HasSubstr("the journal stands 1.1 of the clearance out of its sleeve's centre"));
  const auto refused = [&](const std::string& keys) {
    return refusal(
        wheel +
        "[force.b]\ntype = \"journal_bearing\"\nfrom = \"ground\"\nto = \"wheel\"\nradius = 0.03\nlength "
        "= 0.02\n" +
        keys);
  };
  EXPECT_THAT(refused("clearance = 0.04\nviscosity = 0.02\n"), HasSubstr("is not below the radius"));
  EXPECT_THAT(refused("clearance = 1e-4\nviscosity = \"-1\"\n"), HasSubstr("must be above 0"));
}

}  // namespace
}  // namespace flexura::mbs::cases
