// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mbs/superelement/file.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/mbs/moving/girder.hpp"
#include "tests/mbs/surfaces/ribbon.hpp"
#include "tests/reference.hpp"

/// A block that slides down a plane which its own weight has bent: the surface of a superelement, against an equation of one
/// unknown.
namespace flexura::mbs::surfaces {
namespace {

using cases::Series;
using cases::simulate;

constexpr double kL = 2.0, kEI = 60.0, kLine = 3.0, kSlope = 0.45, kG = 9.81, kWidth = 0.02;  // of the plank
constexpr double kMass = 1e-3, kRadius = 0.5, kMu = 0.25, kDepth = 1e-3, kStart = 0.2, kSpeed = 0.3;

/// The plank lies on two supports, tilted by kSlope, and sags under its weight by 5 q L^4 / (384 EI) = 92 mm.
struct Plank {
  static constexpr double kQ = kLine * kG;
  static double load() { return kQ * std::cos(kSlope); }
  static double w(double x) { return -load() * x * (kL * kL * kL - 2 * kL * x * x + x * x * x) / (24 * kEI); }
  static double w_1(double x) {
    return -load() * (kL * kL * kL - 6 * kL * x * x + 4 * x * x * x) / (24 * kEI);
  }
  static double w_2(double x) { return load() * x * (kL - x) / (2 * kEI); }
};

/// A runner of the radius R slides without turning: its axis is at R - d from the curve it touches at the place s, so that with
/// the curve's curvature k and the axis' speed v
///
///     s' = v / ((1 - k (R - d)) sqrt(1 + w'^2)),   N = m (v^2 k / (1 - k (R - d)) - g . n),   v' = g . t - mu N / m.
struct Block {
  static double rho() { return kRadius - kDepth; }
  static Vector3d axis(double s) {
    const double slope = Plank::w_1(s);
    return Vector3d(s, 0.0, Plank::w(s)) + rho() / std::hypot(1.0, slope) * Vector3d(-slope, 0.0, 1.0);
  }
  static double normal_force(double s, double v) {
    const double slope = Plank::w_1(s), h = std::hypot(1.0, slope), k = Plank::w_2(s) / (h * h * h);
    const double g_n = (-slope * std::sin(kSlope) - std::cos(kSlope)) * kG / h;
    return kMass * (v * v * k / (1.0 - k * rho()) - g_n);
  }
  static Eigen::VectorXd rate(double, const Eigen::VectorXd& y) {
    const double s = y(0), v = y(1), slope = Plank::w_1(s), h = std::hypot(1.0, slope),
                 k = Plank::w_2(s) / (h * h * h),
                 g_t = (std::sin(kSlope) - slope * std::cos(kSlope)) * kG / h;
    return Eigen::Vector2d(v / ((1.0 - k * rho()) * h), g_t - kMu * normal_force(s, v) / kMass);
  }
};

class BentPlane : public cases::TextCase {
 protected:
  void SetUp() override {
    cases::TextCase::SetUp();
    beams::StraightBeam beam;
    beam.length = kL;
    beam.elements = 32;
    beam.between = 15;
    beam.EA = 1e9;
    beam.EI_y = beam.EI_z = kEI;
    beam.GI_t = 100.0;
    beam.mass_per_length = kLine;
    beam.rho_I_y = beam.rho_I_z = 1e-6;
    superelement::write(folder_ / "plank.se.h5", ribbon(beam, kWidth, 40));
  }
};

TEST_F(BentPlane, BlockSlidesDownAPlankBentByItsWeight) {
  const double end = 0.9;
  const int rows = 45;
  // Pressure over a cylinder's gap, a parabola of the half width a^2 = 2 d / (1/R - k): N = 4/3 a d k_p b.
  const double k = Plank::w_2(kStart), a = std::sqrt(2.0 * kDepth / (1.0 / kRadius - k));
  const double pressure = Block::normal_force(kStart, kSpeed) / (4.0 / 3.0 * a * kDepth * kWidth);
  const Vector3d at = Block::axis(kStart);
  const double slope = Plank::w_1(kStart);
  const Vector3d v = kSpeed / std::hypot(1.0, slope) * Vector3d(1.0, 0.0, slope);
  const auto p = prepared(fmt::format(R"toml(
gravity = [{}, 0, {}]
[body.plank]
superelement = "plank.se.h5"
fidelity = "static"
[body.plank.marker.hinge]
on = "root"
axis = [0, 1, 0]
[ground.marker.hinge]
axis = [0, 1, 0]
[ground.marker.line]
axis = [1, 0, 0]
[joint.hinge]
type = "revolute"
from = "ground.hinge"
to = "plank.hinge"
[constraint.guide]
type = "point_on_line"
from = "ground.line"
to = "plank.tip"
[body.block]
mass = {}
inertia = [1e-5, 1e-5, 1e-5]
position = [{:.15g}, 0, {:.15g}]
velocity = [{:.15g}, 0, {:.15g}]
[body.block.marker.axis]
axis = [0, 1, 0]
[constraint.upright]
type = "orientation"
from = "ground"
to = "block"
[force.touch]
type = "surface_contact"
body = "plank"
from = "block.axis"
surface = "cylinder"
surface_radius = {}
stiffness = "{:.15g}"
friction = {}
transition_speed = "0.1 mm/s"
)toml",
                                      kG * std::sin(kSlope), -kG * std::cos(kSlope), kMass, at.x(), at.z(),
                                      v.x(), v.z(), kRadius, pressure, kMu) +
                          moving::solve(end, rows, 1e-7, "initial_deformation = \"quasi_static\"\n"));
  const Series run = simulate(p, {"block.position_x", "block.position_z", "touch.normal_force",
                                  "touch.friction_force", "touch.nodes"});
  Eigen::VectorXd y = Eigen::Vector2d(kStart, kSpeed);
  double t = 0.0, worst = 0.0, force = 0.0, exact_force = 0.0;
  for (int row = 1; row <= rows; ++row) {
    for (int i = 0; i < 100; ++i) moving::kutta(Block::rate, t, y, end / rows / 100);
    const Eigen::VectorXd& ours = run.values[static_cast<std::size_t>(row)];
    worst = std::max(worst, (Vector3d(ours(0), 0.0, ours(1)) - Block::axis(y(0))).norm());
    force += ours(2) / rows;
    exact_force += Block::normal_force(y(0), y(1)) / rows;
    EXPECT_NEAR(ours(3), kMu * ours(2),
                2e-3 * kMu * ours(2));  // nodes push by 4 degrees to either side of the normal
    EXPECT_GT(ours(4), 30.0);
  }
  const double way = y(0) - kStart,
               straight = kSpeed * end + 0.5 * kG * (std::sin(kSlope) - kMu * std::cos(kSlope)) * end * end;
  EXPECT_GT(std::abs(way - straight), 0.2 * way);  // so much is the bend's
  // The runner goes up and down in its depth of 1 mm, which nothing damps, by a fifth of it.
  const flexura::test::Reference equation = {
      "a block slides down a plank bent by its weight: equation of one unknown by Kutta's method",
      "the depth of the contact, 1 mm, in which the runner goes up and down"};
  flexura::test::expect_reference("largest distance from where it should be", "m", worst, 0.0, kDepth,
                                  equation);
  flexura::test::expect_reference("mean normal force", "N", force, exact_force, 0.02 * exact_force, equation);
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-5);
}

}  // namespace
}  // namespace flexura::mbs::surfaces
