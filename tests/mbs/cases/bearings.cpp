// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "mbs/forces/contacts/hertz.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/reference.hpp"

/// Rolling bearings and bearings by matrices against published load distributions and closed forms.
namespace flexura::mbs::cases {
namespace {

using ::testing::HasSubstr;
constexpr double pi = std::numbers::pi;

class Bearings : public TextCase {
 protected:
  static std::string shaft(const std::string& place) {
    return "gravity = [0, 0, 0]\n[body.shaft]\nmass = 3\ninertia = [0.02, 0.02, 0.01]\n" + place + "\n";
  }
  static std::string bearing(const std::string& type, const std::string& keys) {
    return "[force.b]\ntype = \"" + type + "\"\nfrom = \"ground\"\nto = \"shaft\"\n" + keys + "\n";
  }
  Eigen::VectorXd loads(const std::string& place, const std::string& keys) const {
    return now(
        prepared(shaft(place) + bearing("rolling_bearing", keys) + solver),
        {"b.force_x", "b.force_y", "b.force_z", "b.torque_x", "b.torque_y", "b.largest_load", "b.loaded"});
  }
};

const std::string many_balls = "elements = 100\ndiameter = \"5 mm\"\npitch_diameter = \"200 mm\"\n";

constexpr flexura::test::Reference harris_table{"T. A. Harris, Rolling Bearing Analysis, 3rd ed., table 5.1",
                                                "the table's digits"};
constexpr flexura::test::Reference stribeck{
    "Load distribution by Stribeck and Sjoevall (NSK Technical Report E728g, 5.1)",
    "the factors' three digits"};
constexpr flexura::test::Reference harris_218{
    "T. A. Harris, angular contact bearing 218 (equation 6.9, table 5.1)",
    "per mille between rows of the table, to the power 3/2, on both contacts"};

TEST(Hertz, ApproachIsThatOfHarrisTable) {
  // T. A. Harris, Rolling Bearing Analysis, 3rd ed., table 5.1: F(rho), a*, b*, delta*; four digits.
  const double table[][4] = {{0.1075, 1.0760, 0.9318, 0.9974}, {0.3204, 1.2623, 0.8114, 0.9761},
                             {0.4795, 1.4556, 0.7278, 0.9429}, {0.5916, 1.6440, 0.6687, 0.9077},
                             {0.7332, 2.011, 0.5881, 0.8394},  {0.90999, 3.233, 0.4499, 0.6636},
                             {0.95738, 4.395, 0.3830, 0.5551}};
  for (const auto& [F, a, b, delta] : table) {
    const std::string at = fmt::format(", F(rho) = {}", F);
    flexura::test::expect_reference("Hertz' contact, delta*" + at, "", hertz::approach_factor(F), delta,
                                    2e-3 * delta, harris_table);
    flexura::test::expect_reference("Hertz' contact, a*/b*" + at, "", hertz::axis_ratio(F), a / b,
                                    5e-3 * a / b, harris_table);
  }
  // Two spheres: delta^3 = 9 Q^2 / (16 R E*^2), with Sigma = 2 / R and E' = 2 E*.
  const double R = 0.01, E_star = 1e11;
  EXPECT_NEAR(hertz::point_stiffness(2.0 / R, 0.0, 2.0 * E_star), 4.0 / 3.0 * E_star * std::sqrt(R),
              1e-9 * E_star);
  EXPECT_THROW(hertz::axis_ratio(1.0), std::invalid_argument);
}

TEST_F(Bearings, LargestLoadIsStribecks) {
  // Half of the ring carries: Q_max = 4.37 F / Z for balls, 4.08 F / Z for rollers (NSK Technical Report E728g, 5.1, after
  // Stribeck and Sjoevall): the mean over the ring is an integral that 100 elements give to 1e-3.
  const std::string small = "position = [1e-7, 0, 0]";
  Eigen::VectorXd f = loads(small, many_balls);
  EXPECT_LT(f(0), 0.0);
  flexura::test::expect_reference("balls, Z Q_max / F_r", "", -f(5) * 100 / f(0), 4.37, 0.01, stribeck);
  EXPECT_NEAR(f(1), 0.0, 1e-12 * std::abs(f(0)));
  EXPECT_EQ(f(6), 49.0);
  f = loads(small, many_balls + "kind = \"roller\"\nlength = \"8 mm\"\n");
  flexura::test::expect_reference("rollers, Z Q_max / F_r", "", -f(5) * 100 / f(0), 4.08, 0.01, stribeck);
  // With a contact angle the thrust of the same half: F_a = 1.216 F_r tan(alpha), rollers 1.260 (same source).
  f = loads(small, many_balls + "contact_angle = \"25 deg\"\n");
  flexura::test::expect_reference("balls, F_a / F_r tan(alpha)", "", f(2) / f(0) / std::tan(25 * pi / 180),
                                  1.216, 0.01, stribeck);
  EXPECT_NEAR(-f(5) * 100 * std::cos(25 * pi / 180) / f(0), 4.37, 0.01);
  f = loads(small, many_balls + "contact_angle = \"15 deg\"\nkind = \"roller\"\nlength = \"8 mm\"\n");
  flexura::test::expect_reference("rollers, F_a / F_r tan(alpha)", "", f(2) / f(0) / std::tan(15 * pi / 180),
                                  1.260, 0.01, stribeck);
}

TEST_F(Bearings, ThrustOfA218IsThatOfHarrisConstants) {
  // Harris, 3rd ed.: a 218 angular contact bearing, 16 balls of 22.23 mm on 125.3 mm, grooves 0.5232, 40 deg (example 2.6:
  // sums of curvatures 0.108 and 0.0832 / mm, differences 0.926 and 0.904).  Each contact has 2.15e5 Sigma^(-1/2)
  // delta*^(-3/2) N/mm^(3/2) (equation 6.9) with delta* 0.632 and 0.672 between rows of table 5.1, right to some per mille.
  // (The chart of constants that the book's example of thrust reads gives a tenth less than this.)
  const std::string angular =
      "elements = 16\ndiameter = \"22.23 mm\"\npitch_diameter = \"125.3 mm\"\ncontact_angle = \"40 deg\"\n"
      "groove_inner = 0.5232\ngroove_outer = 0.5232\n";
  const auto contact = [](double sum, double delta) {
    return 2.15e5 / std::sqrt(sum) * std::pow(delta, -1.5);
  };
  const double K =
      std::pow(std::pow(contact(0.1081, 0.632), -2.0 / 3) + std::pow(contact(0.0832, 0.672), -2.0 / 3), -1.5);
  const double A = 0.0464 * 22.23, a_0 = 40 * pi / 180, moved = 0.0386;
  const double r = A * std::cos(a_0), z = A * std::sin(a_0) + moved, angle = std::atan2(z, r);
  EXPECT_NEAR(angle * 180 / pi, 41.6, 0.05);  // as in the example of thrust
  const double Q = K * std::pow(std::hypot(r, z) - A, 1.5);
  const Eigen::VectorXd f = loads("position = [0, 0, 38.6e-6]", angular);
  flexura::test::expect_reference("load of one ball at 38.6 um of thrust", "N", f(5), Q, 0.015 * Q,
                                  harris_218);
  EXPECT_NEAR(-f(2), 16 * f(5) * std::sin(angle), 1e-9 * f(5));
  // Against - z it carries nothing.
  EXPECT_EQ(loads("position = [0, 0, -38.6e-6]", angular)(2), 0.0);
}

TEST_F(Bearings, ClearanceIsFreeAndInterferenceLoadsAll) {
  EXPECT_EQ(loads("position = [9e-6, 0, 0]", many_balls + "clearance = \"20 um\"\n").norm(), 0.0);
  EXPECT_LT(loads("position = [11e-6, 0, 0]", many_balls + "clearance = \"20 um\"\n")(0), 0.0);
  const Eigen::VectorXd f = loads("position = [0, 0, 0]", many_balls + "clearance = \"-20 um\"\n");
  EXPECT_EQ(f(6), 100.0);
  EXPECT_NEAR(f.head<3>().norm(), 0.0, 1e-9 * f(5));
}

TEST_F(Bearings, RollersTiltAsTheirLinesSay) {
  // Tilt theta about x: rollers at (cos, sin) are pressed by x_k theta sin along their length.  Linear springs would give
  // c L^2 / 12 theta Z / 2; with delta^(10/9) and half of each line in touch, an integral done here on its own.
  const double theta = 1e-4, L = 0.012, c = 3.5948e10 * std::pow(L, 8.0 / 9.0);
  const Eigen::VectorXd f = loads("rotation = [1e-4, 0, 0]",
                                  "kind = \"roller\"\nelements = 16\ndiameter = \"10 mm\"\npitch_diameter = "
                                  "\"80 mm\"\nlength = \"12 mm\"\n");
  double torque = 0.0;
  for (int j = 0; j < 16; ++j)
    for (int k = 0; k < 4000; ++k) {
      const double z = L * ((k + 0.5) / 4000 - 0.5), across = -std::sin(2 * pi * j / 16) * theta;
      const double delta = z * across;
      if (delta > 0.0) torque += c / 4000 * std::pow(delta, 10.0 / 9.0) * z * std::sin(2 * pi * j / 16);
    }
  EXPECT_NEAR(f(3), torque, 3e-3 * std::abs(torque));  // 30 slices
  EXPECT_LT(f(3), 0.0);
}

TEST_F(Bearings, EnergyOfAShaftInBallBearingsIsKept) {
  const std::string text = shaft(
      "angular_velocity = [3, -2, 300]\nvelocity = [0.05, 0.02, 0.03]\n"
      "[body.shaft.marker.a]\nposition = [0, 0, -0.1]\n[body.shaft.marker.b]\n"
      "position = [0, 0, 0.1]\nrotation = [3.141592653589793, 0, 0]\n"
      "[ground.marker.a]\nposition = [0, 0, -0.1]\n[ground.marker.b]\nposition = [0, 0, 0.1]\n"
      "rotation = [3.141592653589793, 0, 0]");
  const std::string keys =
      "elements = 11\ndiameter = \"9 mm\"\npitch_diameter = \"45 mm\"\ncontact_angle = \"25 deg\"\n";
  std::string forces;
  for (const char* end : {"a", "b"})
    forces += fmt::format(
        "[force.{0}]\ntype = \"rolling_bearing\"\nfrom = \"ground.{0}\"\nto = \"shaft.{0}\"\n{1}"
        "damping = \"40 N*s/m\"\ntilt_damping = \"0.01 N*m*s/rad\"\n",
        end, keys);
  const PreparedMechanism p =
      prepared(text + "\n" + forces + "[solver]\nend_time = 0.02\noutput_step = 1e-3\ntolerance = 1e-9\n");
  const Series s = simulate(p, {"energy.kinetic", "a.largest_load"});
  EXPECT_GT(s.result.energy.dissipated, 1e-4);
  // The energy moved is some 5 mJ of translation; that of the spin, 450 J, stands still.
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-6);
}

TEST_F(Bearings, MatrixHoldsAShaftThatSpins) {
  // m g / k below, whatever it turns; the whirl of an unsymmetric matrix grows as its energy book says.
  const std::string spinning =
      "gravity = [0, -9.81, 0]\n[body.shaft]\nmass = 3\ninertia = [0.02, 0.02, 0.01]\n"
      "position = [0, -2.943e-5, 0]\nangular_velocity = [0, 0, 500]\n";
  const std::string K =
      "stiffness_matrix = [[1e6, 0, 0, 0, 0], [0, 1e6, 0, 0, 0], [0, 0, 1e6, 0, 0], [0, 0, 0, 1e4, 0], "
      "[0, 0, 0, 0, 1e4]]\n";
  const std::string run = "[solver]\nend_time = 0.1\noutput_step = 0.01\ntolerance = 1e-10\n";
  const Series still =
      simulate(prepared(spinning + bearing("bearing", K) + run), {"shaft.position_y", "b.force_y"});
  for (const Eigen::VectorXd& row : still.values) {
    EXPECT_NEAR(row(0), -3 * 9.81 / 1e6, 1e-12);
    EXPECT_NEAR(row(1), 3 * 9.81, 1e-6);
  }
  const std::string cross =
      "stiffness_matrix = [[1e6, 1e5, 0, 0, 0], [-1e5, 1e6, 0, 0, 0], [0, 0, 1e6, 0, 0], "
      "[0, 0, 0, 1e4, 0], [0, 0, 0, 0, 1e4]]\ndamping_matrix = [[50, 0, 0, 0, 0], [0, 50, 0, 0, 0], "
      "[0, 0, 50, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 1]]\n";
  const PreparedMechanism p = prepared(shaft("velocity = [0.1, 0, 0]") + bearing("bearing", cross) + run);
  const Series s = simulate(p, {"shaft.position_x", "shaft.position_y"});
  // Complex z = x + i y: m z'' + d z' + (k - i k_c) z = 0.
  const std::complex<double> i(0.0, 1.0),
      root = std::sqrt(std::complex<double>(50.0 * 50.0) - 12.0 * (1e6 - i * 1e5));
  const std::complex<double> l1 = (-50.0 + root) / 6.0, l2 = (-50.0 - root) / 6.0;
  for (std::size_t k = 0; k < s.t.size(); ++k) {
    const std::complex<double> z = 0.1 / (l1 - l2) * (std::exp(l1 * s.t[k]) - std::exp(l2 * s.t[k]));
    EXPECT_NEAR(s.values[k](0), z.real(), 1e-8);
    EXPECT_NEAR(s.values[k](1), z.imag(), 1e-8);
  }
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-7);
}

TEST_F(Bearings, RefuseWhatCannotBe) {
  const auto refused = [&](const std::string& type, const std::string& keys) {
    return refusal(shaft("") + bearing(type, keys));
  };
  EXPECT_THAT(
      refused("rolling_bearing", "elements = 40\ndiameter = \"20 mm\"\npitch_diameter = \"100 mm\"\n"),
      HasSubstr("do not fit on the pitch diameter"));
  EXPECT_THAT(refused("rolling_bearing", many_balls + "groove_inner = 0.5\n"),
              HasSubstr("wider than the balls"));
  EXPECT_THAT(refused("rolling_bearing", many_balls + "kind = \"roller\"\n"), HasSubstr("a roller needs it"));
  EXPECT_THAT(refused("rolling_bearing", many_balls + "length = \"8 mm\"\n"), HasSubstr("is a roller's"));
  EXPECT_THAT(refused("rolling_bearing", many_balls + "contact_angle = \"15 deg\"\nclearance = \"5 um\"\n"),
              HasSubstr("balls of angular contact have none"));
  EXPECT_THAT(refused("rolling_bearing", many_balls + "clearance = \"1 mm\"\n"),
              HasSubstr("clearance is larger"));
  EXPECT_THAT(refused("bearing", "stiffness_matrix = [[1, 0], [0, 1]]\n"),
              HasSubstr("neither 5 x 5 nor 6 x 6"));
  EXPECT_THAT(refused("bearing",
                      "stiffness_matrix = [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],"
                      "[0,0,0,0,1,0],[0,0,0,0,0,1]]\n"),
              HasSubstr("holds the turning about z"));
  EXPECT_THAT(refused("bearing",
                      "stiffness_matrix = [[1,0,0,0,0],[0,1,0,0,0],[0,0,1,0,0],[0,0,0,1,0],[0,0,0,0,1]]\n"
                      "damping_matrix = [[1,4,0,0,0],[4,1,0,0,0],[0,0,1,0,0],[0,0,0,1,0],[0,0,0,0,1]]\n"),
              HasSubstr("puts power in"));
}

}  // namespace
}  // namespace flexura::mbs::cases
