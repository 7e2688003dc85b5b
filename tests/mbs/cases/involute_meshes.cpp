// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "mbs/forces/gears/involute.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/reference.hpp"

/// Involute teeth: published geometry, ISO's stiffness, directions of forces, play, energy.
namespace flexura::mbs::cases {
namespace {

using ::testing::HasSubstr;
constexpr double pi = std::numbers::pi, degree = pi / 180.0;

double inv(double angle) {
  return std::tan(angle) - angle;
}

InvoluteData spur() {
  InvoluteData d;
  d.module = 3e-3;
  d.teeth_1 = 20;
  d.teeth_2 = 40;
  d.pressure_angle = 20 * degree;
  d.width = 0.02;
  return d;
}

constexpr flexura::test::Reference khk{"KHK Gear Technical Reference, calculation of gear dimensions",
                                       "the table's last digit"};

TEST(Involute, GeometryIsThatOfGearTables) {
  // KHK Gear Technical Reference, calculation of gear dimensions: profile shifted spur gears (module 3 mm, 12 and 24 teeth,
  // x = 0.6 and 0.36): working pressure angle 26.0886 deg, centre distance 56.4999 mm; helical (normal module 3 mm, 12 and
  // 60 teeth, 30 deg, x = 0.09809 and 0): 23.1126 deg and 125.000 mm.
  InvoluteData d = spur();
  d.teeth_1 = 12, d.teeth_2 = 24, d.shift_1 = 0.6, d.shift_2 = 0.36;
  const Involute shifted(d);
  flexura::test::expect_reference("spur gears, shifted: working pressure angle", "deg",
                                  shifted.working_angle / degree, 26.0886, 1e-4, khk);
  flexura::test::expect_reference("spur gears, shifted: centre distance", "mm", 1e3 * shifted.centre_distance,
                                  56.4999, 1e-4, khk);
  d.teeth_1 = 12, d.teeth_2 = 60, d.shift_1 = 0.09809, d.shift_2 = 0.0, d.helix_angle = 30 * degree;
  const Involute helical(d);
  flexura::test::expect_reference("helical gears: transverse pressure angle", "deg",
                                  helical.transverse_angle / degree, 22.79588, 1e-5, khk);
  flexura::test::expect_reference("helical gears: working pressure angle", "deg",
                                  helical.working_angle / degree, 23.1126, 1e-4, khk);
  flexura::test::expect_reference("helical gears: centre distance", "mm", 1e3 * helical.centre_distance,
                                  125.000, 1e-3, khk);
  // Without shift the centre distance is the sum of the reference radii, a tooth is half a pitch thick.
  const Involute plain(spur());
  EXPECT_NEAR(plain.centre_distance, 90e-3, 1e-12);
  EXPECT_NEAR(plain.half_thickness_1, pi / 40, 1e-12);
  // Contact ratio of the textbooks.
  const auto path = [](double z) {
    return std::sqrt(std::pow(z / 2 + 1, 2) - std::pow(z / 2 * std::cos(20 * degree), 2));
  };
  EXPECT_NEAR(plain.contact_ratio,
              (path(20) + path(40) - 30 * std::sin(20 * degree)) / (pi * std::cos(20 * degree)), 1e-12);
  EXPECT_NEAR(plain.contact_ratio, 1.635, 1e-3);
}

TEST(Involute, StiffnessIsIsosInTheMeanAndComesBackToothByTooth) {
  const Involute gears(spur());
  // ISO 6336-1: 1 / c'_th = 0.04723 + 0.15551 / 20 + 0.25791 / 40 mm um / N without shift.
  const double c = 0.8 / (0.04723 + 0.15551 / 20 + 0.25791 / 40);
  EXPECT_NEAR(gears.tooth_stiffness, c * 1e9, 1e-3 * c * 1e9);
  EXPECT_NEAR(c, 13.0, 0.1);  // the standard calls 14 N/(mm um) a mean of usual teeth
  EXPECT_NEAR(gears.mean_stiffness, c * 1e9 * (0.75 * gears.contact_ratio + 0.25) * 0.02,
              1e-3 * gears.mean_stiffness);
  // Two pairs in the middle of double contact, one in single contact: with all harmonics 2 / eps and 1 / eps of the mean.
  InvoluteData fine = spur();
  fine.harmonics = 50;
  const Involute steps(fine);
  double mean = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double k = steps.ripple(steps.pitch * i / 1000).value;
    mean += k / 1000;
    EXPECT_NEAR(k, steps.ripple(steps.pitch * (3 + i / 1000.0)).value, 1e-9);
  }
  EXPECT_NEAR(mean, 1.0, 1e-9);
  // Away from the jumps Fourier's series of 50 terms is right to a per cent or two.
  int single = 0, twice = 0;
  for (int i = 0; i < 1000; ++i) {
    const double k = steps.ripple(steps.pitch * i / 1000).value * steps.contact_ratio;
    if (std::abs(k - 1) < 0.05) ++single;
    if (std::abs(k - 2) < 0.05) ++twice;
  }
  EXPECT_NEAR(twice, 1000 * (steps.contact_ratio - 1), 60);
  EXPECT_NEAR(single, 1000 * (2 - steps.contact_ratio), 60);
  // A helix that overlaps by a whole pitch has no ripple left.
  InvoluteData wide = spur();
  wide.helix_angle = 20 * degree;
  wide.width = pi * wide.module / std::sin(wide.helix_angle);
  const Involute smooth(wide);
  EXPECT_NEAR(smooth.overlap_ratio, 1.0, 1e-12);
  for (int i = 0; i < 10; ++i) EXPECT_NEAR(smooth.ripple(smooth.pitch * i / 10).value, 1.0, 1e-12);
}

TEST(Involute, PlayFollowsTheDistanceOfTheAxes) {
  const Involute gears(spur());
  const double sum = gears.base_1 + gears.base_2;
  for (const double a : {90e-3, 90.2e-3, 91e-3}) {
    EXPECT_NEAR(gears.play(a).half, sum * (inv(std::acos(sum / a)) - inv(20 * degree)), 1e-15);
    const double h = 1e-6;
    EXPECT_NEAR(gears.play(a).first, (gears.play(a + h).half - gears.play(a - h).half) / (2 * h), 1e-7);
    EXPECT_NEAR(gears.play(a).second, (gears.play(a + h).first - gears.play(a - h).first) / (2 * h), 1e-4);
  }
  EXPECT_THROW(gears.play(0.9 * sum), std::runtime_error);
}

class InvoluteMeshes : public TextCase {
 protected:
  // Wheels on the axes x = 0 and x = a, driven to the angles q_1 and q_2.
  static std::string wheels(double q_1, double q_2, const std::string& mesh, double a = 90e-3) {
    return fmt::format(R"toml(
gravity = [0, 0, 0]
[ground.marker.two]
position = [{2:.17g}, 0, 0]
[body.one]
mass = 1
inertia = [0.001, 0.001, 0.002]
[body.two]
mass = 2
inertia = [0.01, 0.01, 0.02]
[body.two.marker.space]
rotation = [0, 0, 3.141592653589793]
[joint.first]
type = "revolute"
from = "ground"
to = "one"
drive = "{0:.17g}"
[joint.second]
type = "revolute"
from = "ground.two"
to = "two"
drive = "{1:.17g}"
[force.m]
type = "involute_mesh"
from = "one"
to = "two.space"
module = "3 mm"
teeth_1 = 20
teeth_2 = 40
width = "20 mm"
{3}
)toml",
                       q_1, q_2, a, mesh);
  }
};

TEST_F(InvoluteMeshes, ForcesAreThoseOfTheTextbooks) {
  // Wheel 1 presses by 10 um along the line of action, turning positively; both ways of helix.
  for (const double helix : {0.0, 15.0, -25.0}) {
    const double beta = helix * degree, alpha_t = std::atan(std::tan(20 * degree) / std::cos(beta));
    const double r_1 = 30e-3 / std::cos(beta), a = 90e-3 / std::cos(beta), base_1 = r_1 * std::cos(alpha_t),
                 delta = 1e-5;
    const PreparedMechanism p = prepared(
        wheels(delta / base_1, 0.0, fmt::format("harmonics = 0\nhelix_angle = \"{} deg\"\n", helix), a) +
        solver);
    const Eigen::VectorXd x =
        now(p, {"m.force", "m.position", "m.play", "m.stiffness", "first.drive_force", "second.drive_force",
                "second.force_x", "second.force_y", "second.force_z"});
    EXPECT_NEAR(x(1), delta, 1e-15);
    EXPECT_NEAR(x(2), 0.0, 1e-15);
    EXPECT_NEAR(x(0), x(3) * delta, 1e-9 * x(0));
    // The drives hold T_1 = F r_b1 and T_2 = T_1 z_2 / z_1, both the same way round.
    EXPECT_NEAR(x(4), x(0) * base_1, 1e-9 * x(4));
    EXPECT_NEAR(x(5), 2 * x(4), 1e-9 * x(5));
    // On wheel 2 the axle takes what the teeth give: tangential T_1 / r_1, radial with tan(alpha_t), axial with tan(beta).
    const double tangential = x(4) / r_1;
    EXPECT_NEAR(x(7), -tangential, 1e-9 * tangential);
    EXPECT_NEAR(x(6), -tangential * std::tan(alpha_t), 1e-9 * tangential);
    EXPECT_NEAR(x(8), tangential * std::tan(beta), 1e-9 * tangential);
    // The other flank.
    const Eigen::VectorXd back =
        now(prepared(wheels(-delta / base_1, 0.0,
                            fmt::format("harmonics = 0\nhelix_angle = \"{} deg\"\n", helix), a) +
                     solver),
            {"m.force", "second.force_x", "second.force_y", "second.force_z"});
    EXPECT_NEAR(back(0), -x(0), 1e-9 * x(0));
    EXPECT_NEAR(back(1), x(6), 1e-9 * tangential);
    EXPECT_NEAR(back(2), -x(7), 1e-9 * tangential);
    EXPECT_NEAR(back(3), -x(8), 1e-9 * tangential);
  }
}

TEST_F(InvoluteMeshes, TeethComeAndGoWithTheirFrequency) {
  // Turned by a tooth of each wheel all is as before; in between the stiffness has the mean of ISO 6336.
  const auto stiffness = [&](double q) {
    return now(prepared(wheels(q + 1e-4, -0.5 * q, "harmonics = 2\n") + solver), {"m.stiffness"})(0);
  };
  const double tooth = 2 * pi / 20;
  double mean = 0.0, least = 1e99, most = 0.0;
  for (int i = 0; i < 8; ++i) {
    const double k = stiffness(tooth * i / 8);
    mean += k / 8;
    least = std::min(least, k);
    most = std::max(most, k);
  }
  EXPECT_NEAR(stiffness(0.3 * tooth), stiffness(7.3 * tooth), 1e-4 * mean);
  EXPECT_NEAR(mean, Involute(spur()).mean_stiffness, 1e-9 * mean);
  EXPECT_GT(most / least, 1.3);
}

TEST_F(InvoluteMeshes, BacklashIsFreePlay) {
  const double base_1 = 30e-3 * std::cos(20 * degree), j = 40e-6;
  const auto force = [&](double x, const std::string& keys, double a) {
    return now(prepared(wheels(x / base_1, 0.0, keys + "harmonics = 0\n", a) + solver), {"m.force"})(0);
  };
  const std::string thinned = fmt::format("backlash = {}\n", j);
  EXPECT_EQ(force(0.49 * j, thinned, 90e-3), 0.0);
  EXPECT_EQ(force(-0.49 * j, thinned, 90e-3), 0.0);
  EXPECT_GT(force(0.51 * j, thinned, 90e-3), 0.0);
  EXPECT_LT(force(-0.51 * j, thinned, 90e-3), 0.0);
  // The same by axes 0.1 mm further apart: 2 r_b (inv alpha_w - inv alpha).
  const double sum = 90e-3 * std::cos(20 * degree),
               play = 2 * sum * (inv(std::acos(sum / 90.1e-3)) - inv(20 * degree));
  EXPECT_NEAR(play, 2 * 0.1e-3 * std::sin(20 * degree), 2e-6);
  EXPECT_EQ(force(0.499 * play, "", 90.1e-3), 0.0);
  EXPECT_GT(force(0.501 * play, "", 90.1e-3), 0.0);
  // Three teeth further it is the same tooth space.
  EXPECT_NEAR(force(1e-5 + 3 * pi * 3e-3 * std::cos(20 * degree), "", 90e-3), force(1e-5, "", 90e-3),
              1e-6 * force(1e-5, "", 90e-3));
}

TEST_F(InvoluteMeshes, EnergyOfFlexiblySupportedRattlingWheelsIsKept) {
  // Helical wheels in elastic bearings that tilt and shift, rattling in their play.
  std::string text =
      wheels(0.0, 0.0, "helix_angle = \"15 deg\"\nbacklash = \"60 um\"\n", 90e-3 / std::cos(15 * degree));
  text = text.substr(0, text.find("[joint.first]")) + text.substr(text.find("[force.m]"));
  for (const auto& [body, from] : {std::pair("one", "ground"), std::pair("two", "ground.two")})
    text += fmt::format(
        "[force.{0}_bearing]\ntype = \"bearing\"\nfrom = \"{1}\"\nto = \"{0}\"\nstiffness_matrix = [[1e7, 0, "
        "0, 0, 0], [0, 1e7, 0, 0, 0], [0, 0, 1e7, 0, 0], [0, 0, 0, 1e4, 0], [0, 0, 0, 0, 1e4]]\n",
        body, from);
  const auto with = [&](const std::string& keys) {
    std::string t = text;
    t.insert(t.find("[body.two]"), "angular_velocity = [0, 0, 2]\n");
    t.insert(t.find("[body.two.marker.space]"),
             fmt::format("position = [{:.17g}, 0, 0]\n", 90e-3 / std::cos(15 * degree)));
    t.insert(t.find("[force.one_bearing]"), keys);
    return prepared(t + "[solver]\nend_time = 0.004\noutput_step = 1e-4\ntolerance = 1e-9\n");
  };
  const Series elastic = simulate(with(""), {"m.force", "energy.total"});
  EXPECT_GE(elastic.result.events.size(), 4u);
  // 4 mJ of kinetic energy.
  EXPECT_LT(std::abs(elastic.result.energy.error()), 1e-8);
  EXPECT_NEAR(elastic.values.back()(1), 0.5 * 0.002 * 4.0, 1e-8);
  const Series lossy = simulate(with("restitution = 0.5\n"), {"m.force"});
  EXPECT_GT(lossy.result.energy.dissipated, 1e-4);
  EXPECT_LT(std::abs(lossy.result.energy.error()), 1e-8);
}

TEST_F(InvoluteMeshes, RefuseWhatCannotBe) {
  EXPECT_THAT(refusal(wheels(0, 0, "shift_1 = -8\n")), HasSubstr("base circles overlap"));
  EXPECT_THAT(refusal(wheels(0, 0, "addendum = 0.3\n")), HasSubstr("the contact ratio of the mesh is"));
  EXPECT_THAT(refusal(wheels(0, 0, "helix_angle = \"50 deg\"\n")),
              HasSubstr("the helix angle lies within 45 deg"));
  EXPECT_THAT(refusal(wheels(0, 0, "backlash = \"5 mm\"\n")), HasSubstr("smaller than half a pitch"));
  EXPECT_THAT(refusal(wheels(0, 0, "", 80e-3)), HasSubstr("its wheels mesh at 0.09 m"));
  // Tips at (20 + 2) m / 2 and (40 + 2) m / 2.
  EXPECT_THAT(refusal(wheels(0, 0, "", 97e-3)),
              HasSubstr("its tips no longer reach each other from 0.096 m on"));
  EXPECT_THAT(refusal(wheels(0, 0, "damping = 1\nrestitution = 0.5\n")),
              HasSubstr("stands beside restitution"));
}

}  // namespace
}  // namespace flexura::mbs::cases
