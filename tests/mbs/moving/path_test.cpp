// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "mbs/kinematics/body_path.hpp"
#include "tests/mbs/moving/girder.hpp"

/// Paths on their own, on rigid bodies, and what is no path.
namespace flexura::mbs::moving {
namespace {

using cases::now;
using cases::Series;
using cases::simulate;
using Eigen::Vector3d;
using Eigen::VectorXd;
using ::testing::HasSubstr;

BodyPath straight(const std::vector<double>& x) {
  std::vector<int> markers;
  std::vector<Pose> poses;
  for (const double at : x) {
    markers.push_back(static_cast<int>(markers.size()));
    poses.push_back({Matrix3d::Identity(), {at, 0.0, 0.0}});
  }
  return {markers, poses};
}

// Of five markers and more, a polynomial of degree four with all derivatives, whatever their distances.
TEST(BodyPath, ContinuesPolynomialsOfDegreeFourExactly) {
  const std::vector<double> x = {0.0, 0.4, 0.7, 1.5, 1.9, 2.0, 2.8};
  const BodyPath path = straight(x);
  const auto f = [](double s, int order) {
    const double c[5] = {0.3, -1.0, 0.7, 0.4, -0.2};
    double sum = 0.0;
    for (int p = order; p < 5; ++p) {
      double factor = c[p];
      for (int i = 0; i < order; ++i) factor *= p - i;
      sum += factor * std::pow(s, p - order);
    }
    return sum;
  };
  EXPECT_DOUBLE_EQ(path.length(), 2.8);
  for (const double s : {0.0, 0.1, 0.4, 0.9, 1.7, 1.95, 2.4, 2.8}) {
    const BodyPath::Weights w = path.weights(s);
    for (int order = 0; order < 4; ++order) {
      double sum = 0.0;
      for (int k = 0; k < w.n; ++k) sum += w.b(order, k) * f(x[static_cast<std::size_t>(w.first + k)], 0);
      EXPECT_NEAR(sum, f(s, order), 1e-9) << "s = " << s << ", derivative " << order;
    }
  }
}

// Value, slope and curvature of what is no polynomial go on over every marker; beyond the ends it is straight.
TEST(BodyPath, IsTwiceContinuouslyDifferentiable) {
  const std::vector<double> x = {0.0, 0.5, 0.9, 1.6, 2.0, 2.7, 3.0};
  const BodyPath path = straight(x);
  const auto at = [&](double s, int order) {
    const BodyPath::Weights w = path.weights(s);
    double sum = 0.0;
    for (int k = 0; k < w.n; ++k)
      sum += w.b(order, k) * std::sin(2.0 * x[static_cast<std::size_t>(w.first + k)]);
    return sum;
  };
  for (std::size_t j = 1; j + 1 < x.size(); ++j)
    for (int order = 0; order < 3; ++order) EXPECT_NEAR(at(x[j] - 1e-9, order), at(x[j] + 1e-9, order), 1e-6);
  for (std::size_t j = 0; j < x.size(); ++j) EXPECT_NEAR(at(x[j], 0), std::sin(2.0 * x[j]), 1e-14);
  EXPECT_NEAR(at(3.5, 0), at(3.0, 0) + 0.5 * at(3.0, 1), 1e-13);
  EXPECT_NEAR(at(-0.5, 1), at(0.0, 1), 1e-13);
  EXPECT_EQ(at(3.5, 2), 0.0);
}

class Paths : public cases::TextCase {};

const std::string rod = R"toml(
gravity = [0, 0, 0]
[body.rod]
mass = 1
inertia = [1, 1, 1]
[body.rod.marker.a]
position = [0.1, 0, 0]
[body.rod.marker.b]
position = [0.5, 0, 0]
rotation = [0, 0.3, 0]
[body.rod.marker.c]
position = [2.1, 0, 0]
[joint.spin]
type = "revolute"
from = "ground"
to = "rod"
drive = "2*t"
[body.bead]
mass = 0.7
inertia = [0.1, 0.2, 0.3]
position = [0.4, 0, 0]
velocity = [0, 0.8, 0]
)toml";
const std::string rail =
    "[constraint.slide]\ntype = \"point_on_path\"\npath = [\"rod.a\", \"rod.b\", \"rod.c\"]\nto = "
    "\"bead\"\n";

// On a straight rod that turns: r'' = omega^2 r; from rest at r_0 it is r_0 cosh(omega t), pressed on the rod by
// 2 m omega r' = 2 m omega^2 r_0 sinh(omega t), and its frame turns with the rod.
TEST_F(Paths, BeadFliesOutAlongATurningRod) {
  for (const std::string& orientation : {"free", "along", "fixed"}) {
    SCOPED_TRACE(orientation);
    std::string text = rod;
    if (orientation != "free") text += "angular_velocity = [0, 0, 2]\n";
    const auto p = prepared(text + rail + "orientation = \"" + orientation + "\"\n" + solve(0.8, 8, 1e-9));
    const Series run = simulate(p, {"slide.place", "slide.speed", "slide.force_x", "slide.force_y",
                                    "slide.force_z", "bead.position_y"});
    for (std::size_t i = 0; i < run.t.size(); ++i) {
      const double t = run.t[i], r = 0.4 * std::cosh(2.0 * t), r_dot = 0.8 * std::sinh(2.0 * t);
      EXPECT_NEAR(run.values[i](0), r - 0.1, 1e-6);
      EXPECT_NEAR(run.values[i](1), r_dot, 1e-6);
      EXPECT_NEAR(run.values[i](2), 0.0, 1e-9);
      EXPECT_NEAR(run.values[i](3), 0.7 * 4.0 * r_dot, 1e-5);
      EXPECT_NEAR(run.values[i](4), 0.0, 1e-9);
      EXPECT_NEAR(run.values[i](5), r * std::sin(2.0 * t), 1e-6);
    }
  }
}

// The same with the place given: what drives it is m (s'' - omega^2 r).
TEST_F(Paths, GivenPlaceIsDriven) {
  const auto p = prepared(rod + rail + "place = \"0.3 + t^2\"\n" + solve(0.8, 8, 1e-9));
  const Series run = simulate(p, {"slide.place", "slide.speed", "slide.force_x", "slide.force_y"});
  for (std::size_t i = 0; i < run.t.size(); ++i) {
    const double t = run.t[i], r = 0.4 + t * t;
    EXPECT_NEAR(run.values[i](0), 0.3 + t * t, 1e-12);
    EXPECT_NEAR(run.values[i](1), 2.0 * t, 1e-12);
    EXPECT_NEAR(run.values[i](2), 0.7 * (2.0 - 4.0 * r), 1e-6);
    EXPECT_NEAR(run.values[i](3), 0.7 * 2.0 * 2.0 * 2.0 * t, 1e-6);
  }
}

// Newton's and Euler's equations of a free body on a bent path fixed to ground.
TEST_F(Paths, ReactionsMoveTheBodyAsNewtonAndEulerSay) {
  const std::string text = R"toml(
gravity = [0.3, -0.2, -9.81]
[ground.marker.f]
position = [0.3, 0.1, 0.2]
rotation = [0.3, -0.5, 0.7]
[ground.marker.e]
position = [-0.3, 0.1, 0.1]
[ground.marker.g]
position = [0.8, 0.3, 0.3]
[ground.marker.h]
position = [1.2, 0.7, 0.2]
rotation = [1, 0, 0]
[body.b]
mass = 2
inertia = [0.1, 0.2, 0.15]
position = [0.6, 0.5, 0.7]
rotation = [0.4, 0.2, -0.3]
velocity = [0.4, -0.3, 0.5]
angular_velocity = [1.1, -0.7, 2.0]
[body.b.marker.tip]
position = [0.2, 0.1, -0.15]
[force.twist]
type = "torque"
marker = "b.tip"
x = "0.7"
y = "-0.4"
z = "0.5"
[constraint.c]
type = "point_on_path"
path = ["ground.e", "ground.f", "ground.g", "ground.h"]
to = "b.tip"
)toml";
  const auto vector_of = [](const PreparedMechanism& p, const std::string& name) -> Vector3d {
    return now(p, {name + "_x", name + "_y", name + "_z"});
  };
  for (const std::string& more :
       {std::string("orientation = \"free\"\n"), std::string("orientation = \"along\"\n"),
        std::string("orientation = \"fixed\"\n"),
        std::string("orientation = \"fixed\"\nplace = \"0.7 + t + t^2\"\n")}) {
    SCOPED_TRACE(more);
    const PreparedMechanism p = prepared(text + more);
    const VectorXd q = now(p, {"b.qw", "b.qx", "b.qy", "b.qz"});
    const Matrix3d R = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();
    const Matrix3d J = R * Vector3d(0.1, 0.2, 0.15).asDiagonal() * R.transpose();
    const Vector3d a = vector_of(p, "b.acceleration"), w = vector_of(p, "b.angular_velocity"),
                   alpha = vector_of(p, "b.alpha"), needed = 2.0 * (a - Vector3d(0.3, -0.2, -9.81));
    const Vector3d force = vector_of(p, "c.force");
    EXPECT_NEAR(force.norm(), needed.norm(), 1e-9);
    EXPECT_NEAR(now(p, {"c.force"})(0), force.norm(), 1e-12);
    // A guide that turns the body along a bend pushes it along, too.
    if (more.find("free") != std::string::npos) EXPECT_NEAR(force.x(), 0.0, 1e-9);
    const Vector3d left =
        J * alpha + w.cross(J * w) - Vector3d(0.7, -0.4, 0.5) - (R * Vector3d(0.2, 0.1, -0.15)).cross(needed);
    if (more.find("free") != std::string::npos) {
      EXPECT_LT(left.norm(), 1e-9);
      continue;
    }
    const Vector3d torque = vector_of(p, "c.torque");
    EXPECT_NEAR(torque.norm(), left.norm(), 1e-9);
    // M stands in the path's axes where it is fixed to them.
    if (more.find("fixed") == std::string::npos) continue;
    EXPECT_LT((R * force - needed).norm(), 1e-9);
    EXPECT_LT((R * torque - left).norm(), 1e-9);
  }
}

TEST_F(Paths, GoOnStraightWhereTheySayThat) {
  // r_0 cosh(2 t) is beyond 2.1 m from t = 1.17 s on.
  const PreparedMechanism on = prepared(rod + rail + "ends = \"straight\"\n" + solve(1.2, 12, 1e-8));
  EXPECT_NEAR(simulate(on, {"slide.place"}).values.back()(0), 0.4 * std::cosh(2.4) - 0.1, 1e-5);
}

TEST_F(Paths, RefuseWhatIsNone) {
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = rod + rail;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string all = "[\"rod.a\", \"rod.b\", \"rod.c\"]";
  EXPECT_THAT(refusal(with(all, "[\"rod.a\"]")),
              AllOf(HasSubstr("constraint.slide.path"), HasSubstr("has 1 marker")));
  EXPECT_THAT(refusal(with(all, "[\"rod.a\", \"rod.a\"]")), HasSubstr("the same point twice"));
  EXPECT_THAT(refusal(with(all, "[\"rod.a\", \"rod.c\", \"rod.b\"]")), HasSubstr("turns back at \"rod.c\""));
  EXPECT_THAT(refusal(with(all, "[\"rod.a\", \"rod.d\"]")), HasSubstr("has no marker \"d\""));
  EXPECT_THAT(refusal(with(all, "[\"rod.a\", \"ground\"]")),
              HasSubstr("\"ground\" is on another body than \"rod.a\""));
  EXPECT_THAT(refusal(with("to = \"bead\"", "to = \"rod.b\"")), HasSubstr("is on the body of the path"));
  EXPECT_THAT(refusal(rod + rail + "place = \"3 + t\"\n"),
              HasSubstr("is 3 m at the start, not on the path from 0 to 2 m"));
  EXPECT_THAT(refusal(rod + rail + "near = -1\n"), HasSubstr("is -1 m at the start"));
  EXPECT_THAT(refusal(rod + rail + "near = 1\nplace = \"t\"\n"), HasSubstr("stands beside place"));
  EXPECT_THAT(refusal(rod + rail + "orientation = \"round\"\n"), HasSubstr("orientation"));
  const std::string load =
      rod + "[force.f]\ntype = \"moving_load\"\npath = [\"rod.a\", \"bead\"]\nplace = \"t\"\n";
  EXPECT_THAT(refusal(load + "x = 1\n"), HasSubstr("another body"));
  EXPECT_THAT(
      refusal(rod + "[force.f]\ntype = \"moving_load\"\npath = [\"rod.a\", \"rod.b\"]\nplace = \"t\"\n"),
      HasSubstr("none of x, y, z"));
}

}  // namespace
}  // namespace flexura::mbs::moving
