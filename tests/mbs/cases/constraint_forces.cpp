// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mbs/mechanism/describe.hpp"
#include "tests/mbs/cases/text_case.hpp"

/// Forces of constraints and joints by name, against Newton's and Euler's equations of the bodies they act on.
namespace flexura::mbs::cases {
namespace {

using Eigen::Vector3d;

class ConstraintForces : public TextCase {
 protected:
  static bool offers(const PreparedMechanism& p, const std::string& name) {
    return std::ranges::any_of(p.mechanism->quantities(),
                               [&](const OutputInfo& q) { return q.name == name; });
  }
  /// NAME_x, _y, _z; zero where the mechanism offers none.
  static Vector3d vector_of(const PreparedMechanism& p, const std::string& name) {
    if (!offers(p, name + "_x")) return Vector3d::Zero();
    return now(p, {name + "_x", name + "_y", name + "_z"});
  }
};

// A free body with its centre of mass in its origin, one constraint to ground on two oblique markers.
const std::string free_body = R"toml(
gravity = [0.3, -0.2, -9.81]
[ground.marker.f]
position = [0.1, 0.2, 0.3]
rotation = [0.3, -0.5, 0.7]
[body.b]
mass = 2
inertia = [0.1, 0.2, 0.15]
position = [0.6, 0.5, 0.7]
rotation = [0.4, 0.2, -0.3]
velocity = [0.4, -0.3, 0.5]
angular_velocity = [1.1, -0.7, 2.0]
[body.b.marker.tip]
position = [0.2, 0.1, -0.15]
rotation = [-0.2, 0.6, 0.1]
[force.twist]
type = "torque"
marker = "b.tip"
x = "0.7"
y = "-0.4"
z = "0.5"
)toml";

TEST_F(ConstraintForces, OfEveryTypeBetweenMarkersMoveTheBodyAsNewtonAndEulerSay) {
  const std::string ends = "from = \"ground.f\"\nto = \"b.tip\"\n";
  const std::vector<std::pair<std::string, std::string>> types = {
      {"point_on_line", ends},
      {"point_on_plane", ends},
      {"orientation", ends},
      {"parallel", ends},
      {"perpendicular", ends},
      {"distance", ends + "length = 0.6\n"},
      {"rolling_disc", ends + "radius = 0.15\n"},
      {"point_on_curve", ends + "points = [[0, 0, 0], [0.3, 0.1, 0], [0.6, 0.3, 0.2], [0.9, 0.2, 0.5]]\n"},
      {"user",
       fmt::format("library = \"{}\"\nelement = \"on_ellipsoid\"\nmarkers = [\"ground.f\", \"b.tip\"]\n"
                   "values = {{ a = 0.5, b = 0.4, c = 0.6 }}\n",
                   FLEXURA_USER_LIBRARY)}};
  const Eigen::Matrix3d R_F =
      Eigen::AngleAxisd(Vector3d(0.3, -0.5, 0.7).norm(), Vector3d(0.3, -0.5, 0.7).normalized())
          .toRotationMatrix();
  for (const auto& [type, keys] : types) {
    const PreparedMechanism p = prepared(free_body + "[constraint.c]\ntype = \"" + type + "\"\n" + keys);
    const Eigen::VectorXd q = now(p, {"b.qw", "b.qx", "b.qy", "b.qz"});
    const Eigen::Matrix3d R = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();
    const Eigen::Matrix3d J = R * Vector3d(0.1, 0.2, 0.15).asDiagonal() * R.transpose();
    const Vector3d a = vector_of(p, "b.acceleration"), w = vector_of(p, "b.angular_velocity"),
                   alpha = vector_of(p, "b.alpha");
    const Vector3d force = R_F * vector_of(p, "c.force"), torque = R_F * vector_of(p, "c.torque");
    const Vector3d needed = 2.0 * (a - Vector3d(0.3, -0.2, -9.81));
    EXPECT_LT((force - needed).norm(), 1e-10) << type;
    const Vector3d about_centre =
        torque + (R * Vector3d(0.2, 0.1, -0.15)).cross(force) + Vector3d(0.7, -0.4, 0.5);
    EXPECT_LT((about_centre - (J * alpha + w.cross(J * w))).norm(), 1e-10) << type;
    // Neither is nothing, and sizes are those of the components.
    EXPECT_GT(force.norm() + torque.norm(), 0.1) << type;
    if (offers(p, "c.force")) EXPECT_NEAR(now(p, {"c.force"})(0), force.norm(), 1e-12) << type;
    if (offers(p, "c.torque")) EXPECT_NEAR(now(p, {"c.torque"})(0), torque.norm(), 1e-12) << type;
    // What a type cannot exert it does not offer.
    EXPECT_EQ(offers(p, "c.force"), type != "orientation" && type != "parallel" && type != "perpendicular")
        << type;
  }
}

TEST_F(ConstraintForces, OfALinkIsTensionWhereItPulls) {
  const PreparedMechanism p = prepared(
      "[body.b]\nmass = 3\ninertia = [1, 1, 1]\nposition = [0, 0, -2]\n[constraint.rope]\ntype = "
      "\"distance\"\n"
      "from = \"ground\"\nto = \"b\"\nlength = 2\n");
  EXPECT_NEAR(now(p, {"rope.tension"})(0), 3 * 9.81, 1e-10);
  EXPECT_NEAR(now(p, {"rope.force_z"})(0), 3 * 9.81, 1e-10);
  const PreparedMechanism strut = prepared(
      "[body.b]\nmass = 3\ninertia = [1, 1, 1]\nposition = [0, 0, 2]\n[constraint.rope]\ntype = "
      "\"distance\"\n"
      "from = \"ground\"\nto = \"b\"\nlength = 2\n");
  EXPECT_NEAR(now(strut, {"rope.tension"})(0), -3 * 9.81, 1e-10);
}

// Two shafts and a slide; the first shaft is turned by 5 N m.
const std::string shafts = R"toml(
gravity = [0, 0, 0]
[body.one]
mass = 1
inertia = [1, 1, 0.2]
[body.two]
mass = 1
inertia = [1, 1, 0.7]
[body.slide]
mass = 4
inertia = [1, 1, 1]
[joint.one]
type = "revolute"
from = "ground"
to = "one"
[joint.two]
type = "revolute"
from = "ground"
to = "two"
[joint.slide]
type = "prismatic"
from = "ground"
to = "slide"
[force.turn]
type = "joint_force"
joint = "one"
value = "5"
)toml";

TEST_F(ConstraintForces, OfGearsCouplersAndRacks) {
  {
    const PreparedMechanism p = prepared(shafts +
                                         "[constraint.mesh]\ntype = \"gear\"\njoint_1 = \"one\"\njoint_2 = "
                                         "\"two\"\nteeth_1 = 20\nteeth_2 = 60\n");
    // J_1 + J_2 / 9 is what the first shaft turns.
    const double alpha = 5.0 / (0.2 + 0.7 / 9.0);
    const Eigen::VectorXd y =
        now(p, {"one.acceleration", "two.acceleration", "mesh.torque_1", "mesh.torque_2"});
    EXPECT_NEAR(y(0), alpha, 1e-12);
    EXPECT_NEAR(y(1), -alpha / 3.0, 1e-12);
    EXPECT_NEAR(y(2), 0.2 * alpha - 5.0, 1e-12);
    EXPECT_NEAR(y(3), -0.7 * alpha / 3.0, 1e-12);
  }
  {
    const PreparedMechanism p = prepared(
        shafts +
        "[constraint.pair]\ntype = \"rack_and_pinion\"\nrack = \"slide\"\npinion = \"one\"\nradius = 0.3\n");
    const double alpha = 5.0 / (0.2 + 4.0 * 0.09);
    const Eigen::VectorXd y = now(p, {"slide.acceleration", "pair.force_rack", "pair.torque_pinion"});
    EXPECT_NEAR(y(0), 0.3 * alpha, 1e-12);
    EXPECT_NEAR(y(1), 4.0 * 0.3 * alpha, 1e-12);
    EXPECT_NEAR(y(2), -4.0 * 0.09 * alpha, 1e-12);
  }
  {
    // A differential: one + two = 2 / 0.1 m of the slide.
    const PreparedMechanism p = prepared(shafts +
                                         "[constraint.sum]\ntype = \"coupler\"\njoints = [\"one\", \"two\", "
                                         "\"slide\"]\nfactors = [1, 1, -20]\n");
    const Eigen::VectorXd y = now(p, {"one.acceleration", "two.acceleration", "slide.acceleration",
                                      "sum.torque_1", "sum.torque_2", "sum.force_3"});
    EXPECT_NEAR(y(0) + y(1), 20.0 * y(2), 1e-12);
    EXPECT_NEAR(y(3), 0.2 * y(0) - 5.0, 1e-12);
    EXPECT_NEAR(y(4), 0.7 * y(1), 1e-12);
    EXPECT_NEAR(y(5), 4.0 * y(2), 1e-12);
    // They have no power together.
    EXPECT_NEAR(y(5), -20.0 * y(3), 1e-10);
    EXPECT_GT(std::abs(y(5)), 0.1);
  }
}

// A spatial four-bar, revolute, spherical, universal, revolute: one freedom, and that is driven.
const std::string four_bar = R"toml(
[ground.marker.q]
position = [0.5, 0.1, 0]
axis = [0.1, 1, 0.2]
[ground.marker.o]
axis = [0, 1, 0]
[body.crank]
mass = 1
inertia = [0.01, 0.02, 0.03]
center = [0.05, 0, 0]
[body.crank.marker.o]
axis = [0, 1, 0]
[body.crank.marker.p]
position = [0.1, 0, 0]
[body.rod]
mass = 2
inertia = [0.01, 0.03, 0.03]
center = [0.2, 0.01, 0]
position = [0, 0, -0.1]
[body.rod.marker.u]
position = [0.45, 0, 0]
[body.rocker]
mass = 1.5
inertia = [0.02, 0.02, 0.01]
center = [0, 0, -0.1]
position = [0.5, 0.1, 0]
[body.rocker.marker.q]
axis = [0.1, 1, 0.2]
[body.rocker.marker.u]
position = [0, 0, -0.25]
[joint.A]
type = "revolute"
from = "ground.o"
to = "crank.o"
drive = "1.2 + 15*t + sin(40*t)"
[joint.B]
type = "spherical"
from = "crank.p"
to = "rod"
[joint.C]
type = "universal"
axes = "be-ga"
from = "rod.u"
to = "rocker.u"
[joint.D]
type = "revolute"
from = "ground.q"
to = "rocker.q"
)toml";

TEST_F(ConstraintForces, OfJointsAreTheSameWhereverTheLoopIsCut) {
  std::vector<std::string> names;
  for (const char* joint : {"A", "B", "C", "D"})
    for (const char* what : {"force", "torque"})
      for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("{}.{}_{}", joint, what, axis));
  names.push_back("A.drive_force");
  std::vector<Eigen::VectorXd> all;
  for (const char* cut : {"B", "C", "D"}) {
    std::string text = four_bar;
    const std::string heading = fmt::format("[joint.{}]\n", cut);
    text.insert(text.find(heading) + heading.size(), "cut = true\n");
    const Series s =
        simulate(prepared(text + "[solver]\ntolerance = 1e-7\nend_time = 0.2\noutput_step = 0.05\n"), names);
    all.push_back(s.at(0.2));
    EXPECT_GT(all.back().cwiseAbs().maxCoeff(), 1.0);
    EXPECT_LT((all.back() - all.front()).lpNorm<Eigen::Infinity>(),
              1e-6 * all.front().lpNorm<Eigen::Infinity>())
        << cut;
  }
}

TEST_F(ConstraintForces, OfAJointHoldWhatActsOnItsCoordinateInTheTreeAsInAClosure) {
  // A flap on a hinge with a spring; where the hinge is cut the flap is a free body that the hinge holds.
  const std::string flap = R"toml(
gravity = [0, -9.81, 0]
[body.flap]
mass = 2
inertia = [0.1, 0.1, 0.1]
center = [0.3, 0, 0]
[joint.hinge]
type = "revolute"
from = "ground"
to = "flap"
[force.spring]
type = "joint_spring_damper"
joint = "hinge"
stiffness = 7
rest = -0.4
)toml";
  std::string cut = flap;
  cut.insert(cut.find("[joint.hinge]\n") + 14, "cut = true\n");
  for (const std::string& text : {flap, cut}) {
    const Eigen::VectorXd y = now(prepared(text), {"hinge.torque_z", "hinge.force_y", "hinge.acceleration"});
    EXPECT_NEAR(y(0), -7.0 * 0.4, 1e-11);
    EXPECT_NEAR(y(2), (-7.0 * 0.4 - 2.0 * 9.81 * 0.3) / (0.1 + 2.0 * 0.09), 1e-11);
    EXPECT_NEAR(y(1), 2.0 * (9.81 + 0.3 * y(2)), 1e-11);
  }
}

// A door on two hinges, with a pendulum on its edge.
const std::string door = R"toml(
[ground.marker.high]
position = [0, 0, 1.5]
[body.leaf]
mass = 20
inertia = [2, 2, 2]
center = [0.4, 0, 1]
[body.leaf.marker.low]
position = [0, 0, 0]
[body.leaf.marker.high]
position = [0, 0, 1.5]
[body.leaf.marker.edge]
position = [0.8, 0, 0.5]
axis = [1, 0, 0]
[body.bell]
mass = 1
inertia = [0.01, 0.01, 0.01]
center = [0, 0, -0.2]
[body.bell.marker.top]
axis = [1, 0, 0]
[joint.low]
type = "revolute"
from = "ground"
to = "leaf.low"
[joint.high]
type = "revolute"
from = "ground.high"
to = "leaf.high"
[joint.hook]
type = "revolute"
from = "leaf.edge"
to = "bell.top"
)toml";

TEST_F(ConstraintForces, ThatRedundantHingesShareAreNotUniqueAndTheirSumIs) {
  const PreparedMechanism p = prepared(door);
  ASSERT_EQ(p.redundant.size(), 5u);
  const std::vector<bool> open = p.mechanism->not_unique(p.state.t, p.state.p);
  const auto infos = p.mechanism->quantities();
  for (std::size_t i = 0; i < infos.size(); ++i) {
    const std::string& name = infos[i].name;
    const bool of_a_hinge = name.starts_with("low.force") || name.starts_with("high.force") ||
                            name.starts_with("low.torque") || name.starts_with("high.torque");
    // No hinge can carry a torque about its own axis.
    const bool along_axis = name.ends_with("torque_z");
    EXPECT_EQ(open[i], of_a_hinge && !along_axis) << name;
  }
  const Eigen::VectorXd z = now(p, {"low.force_z", "high.force_z", "hook.force_z"});
  EXPECT_NEAR(z(0) + z(1), 21.0 * 9.81, 1e-8);
}

TEST_F(ConstraintForces, TheRunsOwnEnergiesMayBeAskedForByName) {
  const PreparedMechanism p = prepared(wheel);
  EXPECT_TRUE(select_quantities(*p.mechanism, {"energy.balance"}).empty());
  EXPECT_EQ(select_quantities(*p.mechanism, {"axle.angle", "energy.input"}).size(), 1u);
  EXPECT_THAT(test::refusal_of([&] { select_quantities(*p.mechanism, {"energy.balanse"}); }),
              ::testing::HasSubstr("did you mean \"energy.balance\""));
}

// Steps of changing length make them swing for ever: the run crept at 1e-9 s.
TEST_F(ConstraintForces, AreNotLeftUndampedBySteppingAtWill) {
  const std::string pendulum =
      "[body.m]\nmass = 1\ninertia = [1, 1, 1]\nposition = [1, 0, 0]\n[constraint.rod]\ntype = "
      "\"distance\"\nfrom = \"ground\"\n"
      "to = \"m\"\nlength = 1\n[solver]\nend_time = 1\nmethod = \"generalised_alpha\"\nrho_inf = ";
  EXPECT_THAT(refusal(pendulum + "1\n"),
              ::testing::HasSubstr("solver.rho_inf = 1: leaves constraint forces"));
  EXPECT_NO_THROW(prepared(pendulum + "0.99\n"));
  EXPECT_NO_THROW(prepared(pendulum + "1\nfixed_step = \"1 ms\"\n"));
}

}  // namespace
}  // namespace flexura::mbs::cases
