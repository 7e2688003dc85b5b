// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "mbs/superelement/file.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/mbs/surfaces/plate.hpp"

/// A plate on a plane, flat and on its corner, against closed forms.
namespace flexura::mbs::surfaces {
namespace {

using cases::now;
using cases::Series;
using cases::simulate;

constexpr double kSide = 0.2, kMass = 3.0, kArea = kSide * kSide, kG = 9.81;

class PlateOnPlane : public cases::TextCase {
 protected:
  void SetUp() override {
    cases::TextCase::SetUp();
    superelement::write(folder_ / "plate.se.h5", plate(kSide, 8, kMass));
  }
  static std::string text(const std::string& body, const std::string& contact, double end, int rows,
                          double tolerance = 1e-8) {
    return "[body.plate]\nsuperelement = \"plate.se.h5\"\nfidelity = \"rigid\"\n" + body +
           "[force.touch]\ntype = \"surface_contact\"\nbody = \"plate\"\n" + contact +
           fmt::format("[solver]\nend_time = {:.12g}\noutput_step = {:.12g}\ntolerance = {}\n", end,
                       end / rows, tolerance);
  }
};

// At rest the plate goes in by m g / (k A); all nodes bear the same pressure.
TEST_F(PlateOnPlane, RestsWhereItsWeightIsBorne) {
  const double k = 1e9, depth = kMass * kG / (k * kArea);
  const auto p = prepared(text(fmt::format("position = [0.3, 0.1, {:.15g}]\n", -depth),
                               "from = \"ground\"\nstiffness = \"1e9\"\n", 0.1, 10));
  const Series run = simulate(p, {"touch.gap", "touch.normal_force", "touch.area", "touch.pressure",
                                  "touch.nodes", "touch.force_z", "touch.friction_force"});
  for (const auto& row : run.values) {
    EXPECT_NEAR(row(0), -depth, 1e-6 * depth);
    EXPECT_NEAR(row(1), kMass * kG, 1e-5 * kMass * kG);
    EXPECT_NEAR(row(2), kArea, 1e-12);
    EXPECT_NEAR(row(3), kMass * kG / kArea, 1e-5 * kMass * kG / kArea);
    EXPECT_EQ(row(4), 81.0);
    EXPECT_NEAR(row(5), kMass * kG, 1e-5 * kMass * kG);
    EXPECT_EQ(row(6), 0.0);
  }
}

// Dropped flat from H: a spring of k A stops it within (2 / w) (pi - atan(w v / g)), w^2 = k A / m, v^2 = 2 g H, and throws it
// back as high; again and again, without loss and without a multitude of steps.
TEST_F(PlateOnPlane, BouncesFlatAsASpringDoes) {
  const double H = 0.05, K = 4e5, w = std::sqrt(K / kMass), v = std::sqrt(2.0 * kG * H),
               fall = std::sqrt(2.0 * H / kG), contact = 2.0 / w * (std::numbers::pi - std::atan(w * v / kG)),
               period = 2.0 * fall + contact;
  const auto p = prepared(text(fmt::format("position = [0, 0, {}]\n", H),
                               "from = \"ground\"\ntotal_stiffness = \"4e5 N/m\"\n", 3.0 * period, 3));
  const Series run = simulate(p, {"plate.position_z", "plate.velocity_z"});
  for (const auto& row : run.values) {
    EXPECT_NEAR(row(0), H, 1e-5 * H);
    EXPECT_NEAR(row(1), 0.0, 1e-4 * v);
  }
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-6);
}

// An impact of 0.3 ms in a run whose rows are 0.1 s apart: nothing is leapt over.
TEST_F(PlateOnPlane, IsNotShotThrough) {
  const auto p =
      prepared("gravity = [0, 0, 0]\n" + text("position = [0, 0, 20]\nvelocity = [0, 0, -100]\n",
                                              "from = \"ground\"\ntotal_stiffness = \"3e8 N/m\"\n", 1.0, 10));
  const Series run = simulate(p, {"plate.velocity_z"});
  EXPECT_NEAR(run.values.front()(0), -100.0, 1e-9);
  EXPECT_NEAR(run.values.back()(0), 100.0, 1e-3);
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-6);
}

// Nothing but the contact acts: from m u' = -K delta (1 + c u) follows u_1 = -e u_0 with c u_0 (1 + e) = ln((1 + c u_0) / (1 - e
// c u_0)) (the first integral of Hunt and Crossley's law, as in contact_law.hpp).
TEST_F(PlateOnPlane, LosesByDampingWhatTheFirstIntegralSays) {
  const double e = 0.6, u_0 = 2.0;
  double low = 1e-6, high = 1.0 / e - 1e-9;
  const auto f = [&](double x) { return x * (1.0 + e) - std::log((1.0 + x) / (1.0 - x * e)); };
  low = (1.0 - e) / e;
  for (int i = 0; i < 100; ++i) (f(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
  const auto p = prepared(
      "gravity = [0, 0, 0]\n" +
      text(fmt::format("position = [0, 0, 0.1]\nvelocity = [0, 0, {}]\n", -u_0),
           fmt::format("from = \"ground\"\nstiffness = \"1e9\"\ndamping = {:.15g}\n", low / u_0), 0.2, 4));
  const Series run = simulate(p, {"plate.velocity_z", "touch.force_z"});
  EXPECT_NEAR(run.values.back()(0), e * u_0, 1e-4);
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-6);
}

// A cylinder that slides over damped nodes at the speed v goes into those in front and leaves those behind: over the half width a,
// a^2 = 2 R d, the pressure k (d - x^2 / (2 R)) grows by the factor 1 + c v x / R, and its part along x / R holds
//
//     c v int p (x / R)^2 dx = c v a^2 / (5 R^2) N = 2 c v d / (5 R) N.
TEST_F(PlateOnPlane, DampedNodesHoldBackWhatSlidesOverThem) {
  superelement::write(folder_ / "fine.se.h5", plate(kSide, 40, kMass));
  const double R = 0.5, d = 2e-3, v = 4.0, c = 0.5;
  const auto p = prepared(fmt::format(R"toml(
gravity = [0, 0, 0]
[body.plate]
superelement = "fine.se.h5"
fidelity = "rigid"
[joint.held]
type = "fixed"
from = "ground"
to = "plate"
[body.runner]
mass = 1
inertia = [1, 1, 1]
[body.runner.marker.axis]
axis = [0, 1, 0]
x_axis = [1, 0, 0]
[body.runner.marker.along]
axis = [1, 0, 0]
[ground.marker.rail]
position = [0, 0, {:.12g}]
axis = [1, 0, 0]
[joint.slide]
type = "prismatic"
from = "ground.rail"
to = "runner.along"
drive = "{} * t - 0.04"
[force.touch]
type = "surface_contact"
body = "plate"
from = "runner.axis"
surface = "cylinder"
surface_radius = {}
stiffness = 1e9
damping = {}
[solver]
end_time = 0.02
output_step = 0.001
)toml",
                                      d - R, v, R, c));
  const Series run = simulate(p, {"touch.force_x", "touch.normal_force"});
  double held = 0.0, normal = 0.0;
  for (const auto& row : run.values) {
    held += std::abs(row(0));
    normal += row(1);
  }
  // Squares of a ninth of the half width.
  EXPECT_NEAR(held / normal, 2.0 * c * v * d / (5.0 * R), 0.02 * 2.0 * c * v * d / (5.0 * R));
}

// On its corner and an edge, spinning: energy is kept through many touches, and no row pulls.
TEST_F(PlateOnPlane, TumblesWithoutLoss) {
  const auto p =
      prepared(text("position = [0, 0, 0.3]\nrotation = [0.5, 0.3, 0.1]\nangular_velocity = [3, -2, 1]\n",
                    "from = \"ground\"\ntotal_stiffness = \"1e6 N/m\"\n", 1.0, 200, 1e-7));
  const Series run = simulate(p, {"touch.force_z", "touch.gap"});
  double lowest = 0.0;
  for (const auto& row : run.values) {
    EXPECT_GE(row(0), 0.0);
    lowest = std::min(lowest, row(1));
  }
  EXPECT_GT(lowest, -0.05);
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-5);
}

// Down a slope steeper than friction holds: a = g (sin - mu cos); on one that is not it creeps at v_0 atanh(tan / mu).
TEST_F(PlateOnPlane, SlidesDownASlope) {
  const double k = 1e9;
  for (const double angle : {0.5, 0.2}) {
    const double c = std::cos(angle), s = std::sin(angle), mu = 0.3, v_0 = 1e-4;
    const double depth = kMass * kG * c / (k * kArea);
    const auto p = prepared(text(fmt::format("position = [{:.15g}, 0, {:.15g}]\nrotation = [0, {:.15g}, 0]\n",
                                             -depth * s, -depth * c, angle),
                                 "from = \"ground.slope\"\nstiffness = \"1e9\"\nfriction = "
                                 "0.3\ntransition_speed = \"0.1 mm/s\"\ndamping = "
                                 "\"1 s/m\"\n",
                                 1.0, 10, 1e-7) +
                            fmt::format("[ground.marker.slope]\nrotation = [0, {:.15g}, 0]\n", angle));
    const Series run =
        simulate(p, {"plate.position_x", "plate.position_z", "touch.normal_force", "touch.friction_force"});
    for (std::size_t i = 1; i < run.t.size(); ++i) {
      const double t = run.t[i], way = (run.values[i](0) - run.values[0](0)) * c -
                                       (run.values[i](1) - run.values[0](1)) * s;
      EXPECT_NEAR(run.values[i](2), kMass * kG * c, 1e-3 * kMass * kG);
      if (std::tan(angle) > mu) {
        // Until friction is all there it lags by less than its speed of a few v_0.
        EXPECT_NEAR(way, 0.5 * kG * (s - mu * c) * t * t, 5.0 * v_0 * t);
        EXPECT_NEAR(run.values[i](3), mu * kMass * kG * c, 1e-3 * mu * kMass * kG);
      } else {
        EXPECT_NEAR(way, v_0 * std::atanh(std::tan(angle) / mu) * t, 0.02 * v_0 * t + 1e-8);
      }
    }
    EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-5);
  }
}

}  // namespace
}  // namespace flexura::mbs::surfaces
