// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/LU>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/cases/case_run.hpp"

/// The suspension's kinematics against three scalar equations for the knuckle's rotation, solved here by
/// themselves.
namespace flexura::mbs::cases {
namespace {

// Points of the case, in the design position.
const Vector3d pivot(-0.025, 0.36, 0.215), pivot_axis = Vector3d(0.35, 0, -0.01).normalized();
const Vector3d ball(0.005, 0.70, 0.19), mount(-0.02, 0.58, 0.80), seat(-0.006, 0.647, 0.46);
const Vector3d outer(-0.13, 0.68, 0.25), inner(-0.13, 0.36, 0.245), hub(0, 0.75, 0.3);
constexpr double radius = 0.3;

struct Alignment {
  double bump, toe, camber, half_track;
};

// The knuckle turns by R and its ball follows the arm's.  The mount stays on the strut's axis, the tie rod
// keeps its length.
Alignment exact(double swing, double rack) {
  const Vector3d at = pivot + rotation_exp(swing * pivot_axis) * (ball - pivot);
  const Vector3d along = (mount - seat).normalized(), n_1 = along.unitOrthogonal(), n_2 = along.cross(n_1);
  const double length = (outer - inner).norm();
  const auto residual = [&](const Vector3d& theta) {
    const Matrix3d R = rotation_exp(theta);
    const Vector3d d = at - R * ball, top = R.transpose() * (mount - d) - seat;
    return Vector3d(top.dot(n_1), top.dot(n_2),
                    (R * outer + d - inner - Vector3d(0, rack, 0)).norm() - length);
  };
  Vector3d theta = Vector3d::Zero();
  for (int k = 0; k < 20; ++k) {
    Matrix3d J;
    for (int i = 0; i < 3; ++i)
      J.col(i) =
          (residual(theta + 1e-6 * Vector3d::Unit(i)) - residual(theta - 1e-6 * Vector3d::Unit(i))) / 2e-6;
    theta -= J.partialPivLu().solve(residual(theta));
  }
  EXPECT_LT(residual(theta).norm(), 1e-15);
  const Matrix3d R = rotation_exp(theta);
  const Vector3d axle = R.col(1), center = at + R * (hub - ball);
  const Vector3d down = (axle.z() * axle - Vector3d::UnitZ()) / std::sqrt(1 - axle.z() * axle.z());
  return {center.z() - radius, std::atan2(axle.x(), axle.y()), -std::asin(axle.z()),
          (center + radius * down).y()};
}

TEST(Macpherson, HasTwoFreedomsWithTheRackHeld) {
  const PreparedMechanism p = prepare_case("macpherson/macpherson.toml");
  EXPECT_EQ(p.mechanism->sizes().n_v - p.mechanism->sizes().n_lambda, 2);
  EXPECT_TRUE(p.redundant.empty());
}

TEST(Macpherson, ToeCamberAndTrackFollowTheExactKinematicsOverBumpAndSteer) {
  double most_toe = 0.0;
  for (const double swing : {-0.24, -0.1, 0.0, 0.12, 0.24}) {
    for (const double rack : {-0.06, 0.0, 0.05}) {
      const PreparedMechanism p =
          prepare_case("macpherson/macpherson.toml", {"joint.arm.drive=swing", "joint.hub.drive=0",
                                                      fmt::format("parameters.swing={}", swing),
                                                      fmt::format("parameters.rack_travel={}", rack)});
      const Eigen::VectorXd found = now(p, {"bump", "toe", "camber", "half_track"});
      const Alignment e = exact(swing, rack);
      // Loops are assembled to 1e-10 or better; angles follow over arms of 0.1 m.
      EXPECT_NEAR(found(0), e.bump, 1e-9) << swing << " " << rack;
      EXPECT_NEAR(found(1), e.toe, 1e-9) << swing << " " << rack;
      EXPECT_NEAR(found(2), e.camber, 1e-9) << swing << " " << rack;
      EXPECT_NEAR(found(3), e.half_track, 1e-9) << swing << " " << rack;
      most_toe = std::max(most_toe, std::abs(e.toe));
    }
  }
  EXPECT_GT(most_toe, 0.3);  // the rack steers
}

TEST(Macpherson, AxleOfTwoSubsystemsIsItsOwnMirrorImage) {
  const PreparedMechanism p = prepare_case("macpherson/axle.toml");
  // Two of each suspension, and the car's heave.
  EXPECT_EQ(p.mechanism->sizes().n_v - p.mechanism->sizes().n_lambda, 5);
  EXPECT_EQ(p.mechanism->description().bodies.size(), 2u + 2 * 6);
  const Series s = simulate(
      p, {"left.toe", "right.toe", "left.half_track", "right.half_track", "left.bump", "heave.position"});
  double most = 0.0;
  for (const Eigen::VectorXd& row : s.values) {
    // The same numbers but for round-off, and 1e-8 of the integration.
    EXPECT_NEAR(row(0), row(1), 1e-7);
    EXPECT_NEAR(row(2), row(3), 1e-7);
    most = std::max(most, std::abs(row(5)));
  }
  EXPECT_GT(most, 0.01);
  // Parameters of one side alone, from the command line.
  const PreparedMechanism bent =
      prepare_case("macpherson/axle.toml",
                   {"subsystem.left.parameters.rack_travel=0.01", "subsystem.right.body.wheel.mass=20"});
  EXPECT_GT(std::abs(now(bent, {"left.toe"})(0)), 0.05);
  // The points' digits leave loops open by some 1e-5; where the free arm stands when they are closed depends on both sides.
  EXPECT_NEAR(now(bent, {"right.toe"})(0), now(p, {"right.toe"})(0), 1e-5);
  EXPECT_DOUBLE_EQ(bent.mechanism->description().bodies[10].inertia.mass, 20.0);
  try {
    prepare_case("macpherson/axle.toml", {"subsystem.left.parameters.rack_travl=0.01"});
    ADD_FAILURE();
  } catch (const std::exception& error) {
    EXPECT_NE(
        std::string(error.what()).find("has no parameter \"rack_travl\", did you mean \"rack_travel\"?"),
        std::string::npos)
        << error.what();
  }
}

TEST(Macpherson, LoopsStayClosedToANanometreInEveryRun) {
  const std::vector<std::vector<std::string>> runs = {
      {"joint.arm.drive=swing + 14*pi/180*sin(pi*t)", "joint.hub.drive=0", "force.spring.stiffness=0"},
      {"joint.arm.drive=swing", "joint.hub.drive=0", "joint.rack.drive=0.07*sin(pi*t)",
       "force.spring.stiffness=0"},
      {"solver.tolerance=1e-8"}};
  for (const auto& overrides : runs) {
    const PreparedMechanism p = prepare_case("macpherson/macpherson.toml", overrides);
    const Series s = simulate(p, {"bump", "toe", "arm.angle", "rack.position"});
    EXPECT_LT(s.result.peak_position_drift, 1e-9);
    for (const Eigen::VectorXd& row : s.values) {
      // Rows are interpolated: to the tolerance of the run, on arms of 0.1 m.
      const Alignment e = exact(row(2), row(3));
      EXPECT_NEAR(row(0), e.bump, 1e-6);
      EXPECT_NEAR(row(1), e.toe, 1e-6);
    }
  }
}

}  // namespace
}  // namespace flexura::mbs::cases
