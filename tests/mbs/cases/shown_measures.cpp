// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/mbs/cases/text_case.hpp"

/// Accelerometers, load cells, angles of turns in sequence, and a force along a line by formula.
namespace flexura::mbs::cases {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

class ShownMeasures : public TextCase {};

// A pendulum of 2 kg and 1.5 m about y, from the horizontal.
const std::string pendulum = R"toml(
gravity = [0, 0, -9.81]
[ground.marker.hinge]
axis = [0, 1, 0]
[body.bob]
mass = 2
inertia = [1e-9, 1e-9, 1e-9]
center = [1.5, 0, 0]
[body.bob.marker.hinge]
axis = [0, 1, 0]
[body.bob.marker.tip]
position = [1.5, 0, 0]
rotation = [0, 0.5, 0]
[joint.pivot]
type = "revolute"
from = "ground.hinge"
to = "bob.hinge"
speed = 0.7
[measure.along]
type = "acceleration"
from = "ground"
to = "bob.tip"
axes = "bob"
direction = [2, 0, 0]
[measure.across]
type = "acceleration"
from = "ground"
to = "bob.tip"
axes = "bob"
direction = [0, 0, 1]
[measure.twist]
type = "angular_acceleration"
from = "ground"
to = "bob"
direction = [0, 1, 0]
[measure.seen]
type = "acceleration"
from = "bob"
to = "bob.tip"
direction = [1, 0, 0]
[measure.tension]
type = "load_cell"
joint = "pivot"
axes = "bob"
direction = [-1, 0, 0]
[measure.moment]
type = "load_cell"
joint = "pivot"
quantity = "torque"
at = "bob.tip"
axes = "ground"
direction = [0, 1, 0]
[measure.share]
type = "expression"
value = "tension/(2*9.81)"
)toml";

TEST_F(ShownMeasures, OfAPendulum) {
  const PreparedMechanism p = prepared(pendulum + solver);
  const Series s = simulate(p, {"pivot.angle", "pivot.speed", "pivot.acceleration", "along", "across",
                                "twist", "seen", "tension", "moment", "share"});
  EXPECT_GT(s.t.size(), 10u);
  for (const Eigen::VectorXd& x : s.values) {
    const double l = 1.5, m = 2, g = 9.81, phi = x(0), w = x(1), alpha = x(2);
    EXPECT_NEAR(alpha, g / l * std::cos(phi), 1e-7);  // turning about y takes the bob down
    EXPECT_NEAR(x(3), -l * w * w, 1e-9);
    EXPECT_NEAR(x(4), -l * alpha, 1e-9);
    EXPECT_NEAR(x(5), alpha, 1e-9);
    EXPECT_NEAR(x(6), 0.0, 1e-9);
    EXPECT_NEAR(x(7), m * (l * w * w + g * std::sin(phi)), 1e-6);
    // Along the rod nothing turns about its tip; what the pivot gives across has the arm l, and is 0 for a point mass.
    EXPECT_NEAR(x(8), 0.0, 1e-6);
    EXPECT_NEAR(x(9), x(7) / (2 * 9.81), 1e-12);
  }
}

TEST_F(ShownMeasures, MomentOfAClampedArm) {
  const PreparedMechanism p = prepared(R"toml(
gravity = [0, 0, -10]
[ground.marker.wall]
rotation = [0.3, 0.2, -0.4]
[body.arm]
mass = 3
inertia = [1, 1, 1]
center = [0.8, 0, 0]
[body.arm.marker.wall]
rotation = [0.3, 0.2, -0.4]
[body.arm.marker.gauge]
position = [0.3, 0, 0]
[joint.clamp]
type = "fixed"
from = "ground.wall"
to = "arm.wall"
[measure.shear]
type = "load_cell"
joint = "clamp"
axes = "ground"
direction = [0, 0, 1]
[measure.root]
type = "load_cell"
joint = "clamp"
quantity = "torque"
axes = "arm"
direction = [0, 1, 0]
[measure.gauge]
type = "load_cell"
joint = "clamp"
quantity = "torque"
at = "arm.gauge"
axes = "arm"
direction = [0, 1, 0]
)toml" + solver);
  const Eigen::VectorXd x = now(p, {"shear", "root", "gauge"});
  EXPECT_NEAR(x(0), 30.0, 1e-12);
  EXPECT_NEAR(x(1), -30.0 * 0.8, 1e-12);
  EXPECT_NEAR(x(2), -30.0 * 0.5, 1e-12);
}

TEST_F(ShownMeasures, RefuseWhatTheyAreNotFor) {
  EXPECT_THAT(
      refusal(pendulum +
              "[measure.x]\ntype = \"load_cell\"\njoint = \"pivot\"\nat = \"bob.tip\"\ndirection = [1, 0, "
              "0]\n"),
      HasSubstr("is for a torque"));
  EXPECT_THAT(
      refusal(pendulum +
              "[measure.x]\ntype = \"acceleration\"\nfrom = \"ground\"\nto = \"bob\"\ndirection = [0, 0, "
              "0]\n"),
      HasSubstr("has no length"));
}

TEST_F(ShownMeasures, AnglesOfTurnsInEverySequence) {
  const double q[] = {0.4, 0.7, -1.1};
  for (const std::string sequence :
       {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"}) {
    Eigen::Quaterniond R = Eigen::Quaterniond::Identity();
    for (int i = 0; i < 3; ++i)
      R = R * Eigen::Quaterniond(Eigen::AngleAxisd(q[i], Vector3d::Unit(sequence[i] - 'x')));
    std::string text = fmt::format(
        "gravity = [0, 0, 0]\n[body.b]\nmass = 1\ninertia = [1, 1, 1]\nquaternion = [{:.17g}, "
        "{:.17g}, {:.17g}, {:.17g}]\n",
        R.w(), R.x(), R.y(), R.z());
    for (int i = 1; i <= 3; ++i)
      text += fmt::format(
          "[measure.q{0}]\ntype = \"rotation_angle\"\nfrom = \"ground\"\nto = \"b\"\nsequence = \"{1}\"\n"
          "angle = {0}\n",
          i, sequence);
    const Eigen::VectorXd x = now(prepared(text + solver), {"q1", "q2", "q3"});
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(x(i), q[i], 1e-14) << sequence << " " << i;
  }
}

TEST_F(ShownMeasures, LineForceByFormulaIsTheSpringThatItWrites) {
  const auto text = [](const std::string& force) {
    return R"toml(
gravity = [0, 0, -9.81]
[body.a]
mass = 1
inertia = [0.1, 0.1, 0.1]
position = [0.5, 0, 0]
velocity = [0, 1, 0]
[force.pull]
from = "ground"
to = "a"
)toml" + force +
           solver;
  };
  const PreparedMechanism by_formula =
      prepared(text("type = \"line_force\"\nvalue = \"-200*(pull.length - 0.4) - 3*pull.rate\"\n"));
  const PreparedMechanism spring = prepared(text(
      "type = \"spring_damper\"\nstiffness = \"200 N/m\"\ndamping = \"3 N*s/m\"\nfree_length = \"0.4 m\"\n"));
  const std::vector<std::string> names = {"a.position_x", "a.position_y", "a.position_z", "pull.force",
                                          "pull.length"};
  const Series f = simulate(by_formula, names), k = simulate(spring, names);
  ASSERT_EQ(f.t.size(), k.t.size());
  for (std::size_t i = 0; i < f.t.size(); ++i) {
    EXPECT_LT((f.values[i].head<3>() - k.values[i].head<3>()).norm(), 1e-7);
    EXPECT_NEAR(f.values[i](3), -k.values[i](3), 1e-5);  // pushes, pulls
    EXPECT_NEAR(f.values[i](4), k.values[i](4), 1e-7);
  }
  EXPECT_LT(std::abs(f.result.energy.error()), 1e-6);
  EXPECT_THAT(refusal(text("type = \"line_force\"\nvalue = \"-200*stretch\"\n")), HasSubstr("stretch"));
  EXPECT_THAT(
      refusal(wheel + "[force.f]\ntype = \"line_force\"\nfrom = \"wheel\"\nto = \"wheel\"\nvalue = \"1\"\n"),
      HasSubstr("a line needs two ends"));
}

}  // namespace
}  // namespace flexura::mbs::cases
