// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "tests/mbs/cases/text_case.hpp"

/// Momenta of whole mechanisms, which nothing inside them changes.
namespace flexura::mbs::cases {
namespace {

using Eigen::Vector3d;

class Momentum : public TextCase {};

TEST_F(Momentum, OfBodiesWithoutLoadsIsConserved) {
  const std::string text = R"toml(
gravity = [0, 0, 0]
[body.a]
mass = 2
inertia = [0.1, 0.2, 0.15]
center = [0.1, -0.05, 0.02]
[joint.base]
type = "six_dof"
from = "ground"
to = "a"
v_x = 0.4
v_y = -0.3
v_z = 0.5
omega_x = 1.1
omega_y = -0.7
omega_z = 2.0
[body.a.marker.p]
position = [0.3, 0, 0]
[body.b]
mass = 1
inertia = [0.05, 0.02, 0.03]
center = [0, 0.1, 0]
[joint.ball]
type = "spherical"
from = "a.p"
to = "b"
[body.c]
mass = 0.5
inertia = [0.01, 0.02, 0.03]
position = [0.3, 0.4, 0.5]
velocity = [-1, 0.2, 0.1]
[force.spring]
type = "spring_damper"
from = "b"
to = "c"
stiffness = 50
damping = 2
free_length = 0.3
[solver]
end_time = 1
output_step = 0.1
tolerance = 1e-8
)toml";
  const std::vector<std::string> names = {"momentum.linear_x",  "momentum.linear_y",  "momentum.linear_z",
                                          "momentum.angular_x", "momentum.angular_y", "momentum.angular_z"};
  const PreparedMechanism p = prepared(text);
  const Series s = simulate(p, names);
  for (const Eigen::VectorXd& row : s.values)
    EXPECT_LT((row - s.values.front()).lpNorm<Eigen::Infinity>(), 1e-6) << row.transpose();
  EXPECT_GT(s.values.front().cwiseAbs().minCoeff(), 0.01);
  // At the start body a's own: m (v + w x c), and c x m v + J w about its origin, the world's too.
  const PreparedMechanism alone = prepared(text.substr(0, text.find("[body.a.marker.p]")));
  const Vector3d c(0.1, -0.05, 0.02), v(0.4, -0.3, 0.5), w(1.1, -0.7, 2.0);
  const Vector3d P = 2.0 * (v + w.cross(c)), L = Vector3d(0.1, 0.2, 0.15).cwiseProduct(w) + c.cross(P);
  const Eigen::VectorXd y = now(alone, names);
  EXPECT_LT((y.head<3>() - P).norm(), 1e-14);
  EXPECT_LT((y.tail<3>() - L).norm(), 1e-14);
}

TEST_F(Momentum, OfAFreeBeamThatBendsFarIsConserved) {
  const PreparedMechanism p = prepared(R"toml(
gravity = [0, 0, 0]
[body.a]
fidelity = "ancf"
[body.a.beam]
to = [1, 0, 0]
elements = 2
young = "5 MPa"
density = "1000 kg/m^3"
width = "20 mm"
height = "20 mm"
[body.m]
mass = 0.3
inertia = [0.001, 0.001, 0.001]
[joint.base]
type = "six_dof"
from = "ground"
to = "m"
v_x = 0.2
v_y = 0.1
omega_y = 8
omega_z = 2
[joint.j]
type = "fixed"
from = "m"
to = "a.root"
[solver]
end_time = 0.1
output_step = 0.02
tolerance = 1e-5
)toml");
  const Series s = simulate(p, {"momentum.linear_x", "momentum.linear_y", "momentum.linear_z",
                                "momentum.angular_x", "momentum.angular_y", "momentum.angular_z"});
  for (const Eigen::VectorXd& row : s.values)
    EXPECT_LT((row - s.values.front()).lpNorm<Eigen::Infinity>(), 1e-3 * s.values.front().norm())
        << row.transpose();
}

}  // namespace
}  // namespace flexura::mbs::cases
