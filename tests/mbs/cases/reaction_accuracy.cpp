// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>

#include "tests/mbs/cases/text_case.hpp"

/// Accelerations, reactions and drive forces of rows against closed forms, in every integrator: at the tolerance
/// tau they are within 10 tau of what the motion gives, wherever rows lie in the steps.
namespace flexura::mbs::cases {
namespace {

class ReactionAccuracy : public TextCase {
 protected:
  Series run_with(const std::string& text, const std::string& method, double tolerance, double output_step,
                  double end_time, const std::vector<std::string>& names) const {
    return simulate(prepared(text + fmt::format("[solver]\nmethod = \"{}\"\ntolerance = {:g}\noutput_step = "
                                                "{:.17g}\nend_time = {:.17g}\n",
                                                method, tolerance, output_step, end_time)),
                    names);
  }
};

const std::vector<std::string> methods = {"ida", "radau", "generalised_alpha", "runge_kutta"};

// The rod and the crank have next to no mass, the slider m = 2 kg; r = 0.1 m, l = 0.3 m, W = 50 rad/s:
//     x = r cos f + sqrt(l^2 - r^2 sin^2 f),  f = 0.3 + W t,  drive torque m x'' dx/df,
//     rod force m x'' / cos b with sin b = r sin f / l.
const std::string driven_slider_crank = R"toml(
gravity = [0, 0, 0]
[ground.marker.x]
axis = [1, 0, 0]
[body.crank]
mass = 1e-9
inertia = [1e-9, 1e-9, 1e-9]
[body.crank.marker.p]
position = [0.1, 0, 0]
[body.rod]
mass = 1e-9
inertia = [1e-9, 1e-9, 1e-9]
[body.rod.marker.p]
position = [0.3, 0, 0]
[body.slider]
mass = 2
inertia = [1, 1, 1]
[body.slider.marker.x]
axis = [1, 0, 0]
[joint.motor]
type = "revolute"
from = "ground"
to = "crank"
drive = "50*t + 0.3"
[joint.pin]
type = "revolute"
from = "crank.p"
to = "rod"
[joint.guide]
type = "prismatic"
from = "ground.x"
to = "slider.x"
position = 0.39
[joint.wrist]
type = "revolute"
from = "rod.p"
to = "slider"
)toml";

TEST_F(ReactionAccuracy, OfADrivenSliderCrank) {
  const std::vector<std::string> names = {"motor.drive_force", "guide.acceleration", "wrist.force",
                                          "pin.force"};
  const double r = 0.1, l = 0.3, W = 50.0, m = 2.0;
  for (const std::string& method : methods)
    for (const double tolerance : {1e-4, 1e-6, 1e-9})
      // A row at almost every step, rows that meet no step, more rows than steps.
      for (const double output_step : {0.002, 0.0137, 0.0003}) {
        const Series s = run_with(driven_slider_crank, method, tolerance, output_step, 0.15, names);
        double worst = 0.0;
        Eigen::Vector3d largest = Eigen::Vector3d::Zero();
        std::vector<Eigen::Vector3d> errors;
        for (std::size_t i = 0; i < s.t.size(); ++i) {
          const double f = 0.3 + W * s.t[i], sin_b = r * std::sin(f) / l,
                       cos_b = std::sqrt(1.0 - sin_b * sin_b);
          const double b_1 = r * std::cos(f) / (l * cos_b);  // db/df
          const double x_1 = -r * std::sin(f) - l * sin_b * b_1;
          const double b_2 = -r * std::sin(f) / (l * cos_b) + b_1 * b_1 * sin_b / cos_b;
          const double x_2 = -r * std::cos(f) - l * (cos_b * b_1 * b_1 + sin_b * b_2);
          const double a = W * W * x_2;
          const Eigen::Vector3d exact(m * a * x_1, a, std::abs(m * a / cos_b));
          largest = largest.cwiseMax(exact.cwiseAbs());
          errors.push_back((s.values[i].head<3>() - exact).cwiseAbs());
          // The rod has no mass to speak of: 1e-9 kg at 250 m/s^2.
          EXPECT_NEAR(s.values[i](2), s.values[i](3), 1e-5);
        }
        for (const Eigen::Vector3d& e : errors) worst = std::max(worst, e.cwiseQuotient(largest).maxCoeff());
        EXPECT_LT(worst, 10.0 * tolerance) << method << " at " << tolerance << ", rows " << output_step;
        // All freedoms are driven: whatever the tolerance, the loop closes to 1e-11, and the masses of the rod
        // and the crank are 1e-9 of the slider's.
        EXPECT_LT(worst, 1e-7) << method << " at " << tolerance << ", rows " << output_step;
      }
}

// A point mass on a rod of length L: phi'' = -g/L sin phi, rod force m (g cos phi + L phi'^2).  Once as a joint,
// in the tree, once as a planar body on a link.
const std::string as_joint = R"toml(
gravity = [0, 0, -9.81]
[ground.marker.pivot]
axis = [0, -1, 0]
x_axis = [0, 0, -1]
[body.bob]
mass = 2
inertia = [0.1, 0.1, 0.1]
center = [0.5, 0, 0]
[joint.pivot]
type = "revolute"
from = "ground.pivot"
to = "bob"
angle = 1.2
)toml";
const std::string on_a_link = R"toml(
gravity = [0, -9.81, 0]
[body.bob]
mass = 2
inertia = [0.1, 0.1, 0.1]
[joint.plane]
type = "planar"
from = "ground"
to = "bob"
x = "0.5*sin(1.2)"
y = "-0.5*cos(1.2)"
[constraint.link]
type = "distance"
from = "ground"
to = "bob"
length = 0.5
)toml";

TEST_F(ReactionAccuracy, OfAPendulumOnALink) {
  // Energy gives the force by the height alone: m g (3 cos phi - 2 cos phi_0).
  const double m = 2.0, g = 9.81, L = 0.5, cos_0 = std::cos(1.2);
  for (const std::string& method : methods)
    for (const double tolerance : {1e-4, 1e-6, 1e-9}) {
      const Series s = run_with(
          on_a_link, method, tolerance, 0.013, 1.0,
          {"link.tension", "plane.x", "plane.y", "plane.v_x", "plane.v_y", "link.force", "plane.a_x"});
      double worst = 0.0;
      for (const Eigen::VectorXd& row : s.values) {
        const double cos_f = -row(2) / L, sin_f = row(1) / L, speed_2 = row(3) * row(3) + row(4) * row(4);
        // What the row itself says, to the round-off of a solution.
        EXPECT_NEAR(row(0), m * (g * cos_f + speed_2 / L), 1e-8);
        EXPECT_NEAR(m * row(6), -row(0) * sin_f, 1e-8);
        EXPECT_NEAR(row(5), std::abs(row(0)), 1e-12);
        worst = std::max(worst, std::abs(row(0) - m * g * (3.0 * cos_f - 2.0 * cos_0)));
      }
      // The speed's own error adds up over the run: some hundred steps, and thousands of second order.
      const double steps = method == "generalised_alpha" ? 1000.0 : 100.0;
      EXPECT_LT(worst, steps * tolerance * 3.0 * m * g) << method << " at " << tolerance;
    }
}

TEST_F(ReactionAccuracy, OfAPendulumInTheTree) {
  const double m = 2.0, g = 9.81, L = 0.5;
  for (const std::string& method : methods)
    for (const double tolerance : {1e-4, 1e-8}) {
      const Series s = run_with(as_joint, method, tolerance, 0.013, 1.0,
                                {"pivot.angle", "pivot.speed", "pivot.acceleration", "pivot.force"});
      for (const Eigen::VectorXd& row : s.values) {
        const double w_2 = row(1) * row(1);
        const double alpha = -m * g * L * std::sin(row(0)) / (0.1 + m * L * L);
        EXPECT_NEAR(row(2), alpha, 1e-9);
        const double along = m * (g * std::cos(row(0)) + L * w_2),
                     across = m * (g * std::sin(row(0)) + L * alpha);
        EXPECT_NEAR(row(3), std::hypot(along, across), 1e-8) << method << " at " << tolerance;
      }
    }
}

TEST_F(ReactionAccuracy, OfADriveWhoseAccelerationJumps) {
  // Jerks are infinite at 0.1 and 0.2 s: 40 rad/s^2 for a tenth of a second, then as much back, then rest.
  const std::string text = R"toml(
gravity = [0, 0, 0]
[body.arm]
mass = 1
inertia = [2, 2, 3]
[joint.hub]
type = "revolute"
from = "ground"
to = "arm"
drive = "t < 0.1 ? 20*t^2 : t < 0.2 ? 0.4 - 20*(0.2 - t)^2 : 0.4"
)toml";
  for (const std::string& method : methods) {
    const Series s = run_with(text, method, 1e-6, 0.007, 0.3, {"hub.drive_force", "hub.acceleration"});
    for (std::size_t i = 0; i < s.t.size(); ++i) {
      const double alpha = s.t[i] < 0.1 ? 40.0 : s.t[i] < 0.2 ? -40.0 : 0.0;
      EXPECT_NEAR(s.values[i](1), alpha, 1e-6) << method << " at " << s.t[i];
      EXPECT_NEAR(s.values[i](0), 3.0 * alpha, 3e-6) << method << " at " << s.t[i];
    }
  }
}

TEST_F(ReactionAccuracy, OfAShaftBehindAUniversalJoint) {
  // Bent by b in the xz plane: w_out = W cos b / n, n = 1 - sin^2 b cos^2 f, and J a_out w_out / W is what the
  // drive gives.  The loop of two hinges and the joint is redundant in its bearings, not in its drive.
  const std::string text = R"toml(
gravity = [0, 0, 0]
[parameters]
b = 0.6
[ground.marker.out]
axis = ["sin(b)", 0, "cos(b)"]
[body.in]
mass = 1
inertia = [1, 1, 1e-3]
[body.out]
mass = 1
inertia = [1, 1, 0.5]
[joint.A]
type = "revolute"
from = "ground"
to = "in"
drive = "30*t"
[joint.D]
type = "revolute"
from = "ground.out"
to = "out"
[joint.U]
type = "universal"
from = "in"
to = "out"
)toml";
  const double W = 30.0, b = 0.6, J = 0.5;
  for (const std::string& method : methods) {
    const Series s =
        run_with(text, method, 1e-6, 0.0041, 0.2, {"D.speed", "D.acceleration", "A.drive_force"});
    for (std::size_t i = 0; i < s.t.size(); ++i) {
      const double f = W * s.t[i], n = 1.0 - std::pow(std::sin(b) * std::cos(f), 2);
      const double w = W * std::cos(b) / n;
      const double a = -W * W * std::cos(b) * std::pow(std::sin(b), 2) * std::sin(2.0 * f) / (n * n);
      EXPECT_NEAR(std::abs(s.values[i](0)), w, 1e-8 * W) << method;
      EXPECT_NEAR(s.values[i](1) * s.values[i](0) / w, a, 1e-8 * W * W) << method;
      EXPECT_NEAR(s.values[i](2), J * a * w / W, 1e-8 * J * W * W) << method << " at " << s.t[i];
    }
  }
}

TEST_F(ReactionAccuracy, OfAnUnbalancedRotorAndOfAScrew) {
  const std::string text = R"toml(
[body.rotor]
mass = 3
inertia = [0.1, 0.1, 0.2]
center = [0.002, 0, 0.1]
[joint.bearing]
type = "revolute"
from = "ground"
to = "rotor"
drive = "300*t"
[body.nut]
mass = 5
inertia = [0.1, 0.1, 0.04]
[joint.thread]
type = "screw"
from = "ground"
to = "nut"
pitch = 0.02
drive = "3*sin(7*t)"
)toml";
  const double rise = 0.02 / (2.0 * M_PI);
  for (const std::string& method : methods) {
    const Series s = run_with(text, method, 1e-6, 0.0007, 0.05,
                              {"bearing.force_x", "bearing.force_y", "bearing.force_z", "bearing.torque_x",
                               "thread.drive_force", "thread.force_z"});
    for (std::size_t i = 0; i < s.t.size(); ++i) {
      const double f = 300.0 * s.t[i], F = 3.0 * 0.002 * 300.0 * 300.0;
      EXPECT_NEAR(s.values[i](0), -F * std::cos(f), 1e-8 * F) << method;
      EXPECT_NEAR(s.values[i](1), -F * std::sin(f), 1e-8 * F) << method;
      EXPECT_NEAR(s.values[i](2), 3.0 * 9.81, 1e-8) << method;
      // M = c x F about the origin, the weight's moment and the products of inertia in one.
      EXPECT_NEAR(s.values[i](3), (0.1 * std::sin(f)) * F + 0.002 * std::sin(f) * 3.0 * 9.81, 1e-8 * F)
          << method;
      const double alpha = -147.0 * std::sin(7.0 * s.t[i]);
      EXPECT_NEAR(s.values[i](4), 0.04 * alpha + 5.0 * rise * (rise * alpha + 9.81), 1e-8) << method;
      EXPECT_NEAR(s.values[i](5), 5.0 * (rise * alpha + 9.81), 1e-8) << method;
    }
  }
}

TEST_F(ReactionAccuracy, PowerOfTheDriveIsTheRateOfTheEnergy) {
  const std::string text = R"toml(
[body.crank]
mass = 3
inertia = [0.01, 0.02, 0.02]
center = [0.05, 0, 0]
[body.crank.marker.p]
position = [0.1, 0, 0]
[body.rod]
mass = 1
inertia = [0.001, 0.01, 0.01]
center = [0.2, 0, 0]
[body.rod.marker.p]
position = [0.35, 0, 0]
[body.rocker]
mass = 2
inertia = [0.001, 0.02, 0.02]
center = [0.1, 0, 0]
[body.rocker.marker.p]
position = [0.25, 0, 0]
[ground.marker.o]
axis = [0, -1, 0]
x_axis = [1, 0, 0]
[ground.marker.q]
position = [0.4, 0, 0]
axis = [0, -1, 0]
x_axis = [1, 0, 0]
[joint.motor]
type = "revolute"
from = "ground.o"
to = "crank"
drive = "0.5 + 20*t"
[joint.pin]
type = "revolute"
from = "crank.p"
to = "rod"
[joint.stand]
type = "revolute"
from = "ground.q"
to = "rocker"
angle = 1.6
[joint.knee]
type = "revolute"
from = "rod.p"
to = "rocker.p"
)toml";
  for (const std::string& method : methods) {
    const Series s =
        run_with(text, method, 1e-6, 1e-4, 0.05, {"motor.drive_force", "power.input", "energy.total"});
    for (std::size_t i = 2; i + 2 < s.t.size(); ++i) {
      EXPECT_NEAR(s.values[i](1), 20.0 * s.values[i](0), 1e-9);
      // Differences of the fourth order over 0.1 ms: the crank turns by 0.002 rad in it.
      const auto E = [&](int k) { return s.values[i + k](2); };
      const double rate = (8.0 * (E(1) - E(-1)) - (E(2) - E(-2))) / (12.0 * 1e-4);
      EXPECT_NEAR(s.values[i](1), rate, 1e-6 * 400.0) << method << " at " << s.t[i];
    }
  }
}

}  // namespace
}  // namespace flexura::mbs::cases
