// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mbs/superelement/file.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/mbs/surfaces/ribbon.hpp"

/// A clip: the nose at the tip of an elastic arm is lifted over a round bar and snaps in behind it.
///
/// On the bar of radius r, whose top stands h above the nose at rest, at xi beside its axis, the nose stands at
///
///     w = sqrt(r^2 - xi^2) - (r - h)     and bears     3 E I w / L^3 upwards,   times xi / sqrt(r^2 - xi^2) along:
///
/// the bar is held up as far as the top, by the energy 3 E I h^2 / (2 L^3), and drawn in behind it.
namespace flexura::mbs::surfaces {
namespace {

using cases::Series;
using cases::simulate;

constexpr double kL = 0.1, kEI = 0.0133, kR = 5e-3, kH = 2e-3, kArm = 3.0 * kEI / (kL * kL * kL);

class Clip : public cases::TextCase {
 protected:
  void SetUp() override {
    cases::TextCase::SetUp();
    beams::StraightBeam beam;
    beam.length = kL;
    beam.elements = 16;
    beam.between = 7;
    beam.EA = 4e4;
    beam.EI_y = beam.EI_z = kEI;
    beam.GI_t = 0.01;
    beam.mass_per_length = 0.002;
    beam.rho_I_y = beam.rho_I_z = 1e-10;
    superelement::write(folder_ / "arm.se.h5", ribbon(beam, 1e-4));
  }
  /// The bar's axis comes from beyond the tip, at `place` in front of it.
  static std::string text(double place, const std::string& motion, const std::string& solver) {
    return fmt::format(R"toml(
gravity = [0, 0, 0]
[body.arm]
superelement = "arm.se.h5"
fidelity = "modal"
frame = "joint_fixed"
max_frequency = 5000
damping = 0.1
[joint.wall]
type = "fixed"
from = "ground"
to = "arm.root"
[body.bar]
mass = 0.1
inertia = [1e-5, 1e-5, 1e-5]
position = [{0:.12g}, 0, {1:.12g}]
[body.bar.marker.axis]
axis = [0, 1, 0]
x_axis = [1, 0, 0]
[body.bar.marker.along]
axis = [1, 0, 0]
[ground.marker.rail]
position = [{2}, 0, {1:.12g}]
axis = [1, 0, 0]
[joint.slide]
type = "prismatic"
from = "ground.rail"
to = "bar.along"
{3}
[force.nose]
type = "surface_contact"
body = "arm"
box = [[0.08, -1, -1], [0.11, 1, 1]]
from = "bar.axis"
surface = "cylinder"
surface_radius = {4}
total_stiffness = "4e4 N/m"
damping = "10 s/m"
)toml",
                       kL + place, kH - kR, kL, motion, kR) +
           solver;
  }
};

TEST_F(Clip, IsHeldUpAndDrawnInAsItsArmBends) {
  // From 5 mm in front to 3.9 mm behind the top, so slowly that it stands in equilibrium but for the end.
  const int rows = 89;
  const auto p = prepared(
      text(5e-3, "drive = \"5e-3 - 4.45e-3*t\"\n",
           fmt::format("[solver]\nend_time = 2\noutput_step = {:.12g}\ntolerance = 1e-5\n", 2.0 / rows)));
  const Series run = simulate(p, {"nose.force_x", "nose.force_y", "slide.position"});
  double most = 0.0, least = 0.0;
  for (const auto& row : run.values) {
    const double xi = row(2), height = std::sqrt(std::max(0.0, kR * kR - xi * xi)), w = height - (kR - kH);
    const double up = std::abs(xi) < kR && w > 0.0 ? kArm * w : 0.0, along = -up * xi / height;
    EXPECT_NEAR(-row(1), up, 0.01 * kArm * kH) << xi;
    EXPECT_NEAR(row(0), up > 0.0 ? along : 0.0, 0.01 * kArm * kH) << xi;
    most = std::max(most, row(0));
    least = std::min(least, row(0));
  }
  // As hard to get out as in.
  EXPECT_GT(most, 0.2 * kArm * kH);
  EXPECT_NEAR(least, -most, 0.02 * most);
}

// A slow bar passes where its energy is above that of the arm at the top, and is thrown back where it is below.
TEST_F(Clip, SnapsInWhereTheEnergySuffices) {
  const double barrier = kH * std::sqrt(kArm / 0.1);
  for (const double factor : {0.93, 1.07}) {
    SCOPED_TRACE(factor);
    const double speed = factor * barrier;
    const auto p = prepared(text(5e-3, fmt::format("speed = {:.12g}\n", -speed),
                                 "[solver]\nend_time = 0.6\noutput_step = 0.01\ntolerance = 1e-7\n"));
    const Series run = simulate(p, {"slide.position", "slide.speed"});
    double farthest = 1.0;
    bool passed = false;
    for (const auto& row : run.values) {
      farthest = std::min(farthest, row(0));
      passed = passed || row(0) < -4.2e-3;
    }
    EXPECT_EQ(passed, factor > 1.0) << farthest;
    if (!passed) EXPECT_GT(run.values.back()(1), 0.0);
    EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-5);
  }
}

}  // namespace
}  // namespace flexura::mbs::surfaces
