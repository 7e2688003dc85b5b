// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/solver/exact_motions.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

namespace flexura::mbs::test {

using Eigen::Vector3d;
using Eigen::VectorXd;

std::string slide() {
  return R"toml(gravity = [0, 0, 0]
[ground.marker.m]
[body.a]
mass = 1
inertia = [1, 1, 1]
[body.a.marker.m]
[joint.j]
type = "prismatic"
from = "ground.m"
to = "a.m"
)toml";
}

ExactMotion damped_oscillator(double w, double zeta, double x0, double v0) {
  const double w_d = w * std::sqrt(1.0 - zeta * zeta);
  return {slide() + fmt::format(R"toml(position = {}
speed = {}
[force.s]
type = "joint_spring_damper"
joint = "j"
stiffness = {}
damping = {}
[output]
quantities = ["j.position", "j.speed"]
)toml",
                                x0, v0, w * w, 2.0 * zeta * w),
          [=](double t) -> VectorXd {
            const double decay = std::exp(-zeta * w * t), c = std::cos(w_d * t), s = std::sin(w_d * t);
            return Eigen::Vector2d(decay * (x0 * c + (v0 + zeta * w * x0) / w_d * s),
                                   decay * (v0 * c - (zeta * w * v0 + w * w * x0) / w_d * s));
          }};
}

ExactMotion free_top(double J, double J_e, const Vector3d& w, const Vector3d& turn) {
  const Vector3d e = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * Vector3d::UnitZ();
  const Vector3d L = J * w + (J_e - J) * w.dot(e) * e;
  return {fmt::format(R"toml(gravity = [0, 0, 0]
[body.a]
mass = 2
inertia = [{0}, {0}, {1}]
rotation = [{2}, {3}, {7}]
angular_velocity = [{4}, {5}, {6}]
[output]
quantities = ["a.angular_velocity_*"]
)toml",
                      J, J_e, turn.x(), turn.y(), w.x(), w.y(), w.z(), turn.z()),
          [=](double t) -> VectorXd { return Eigen::AngleAxisd(L.norm() / J * t, L.normalized()) * w; }};
}

ExactMotion sling(double m, double r, double w) {
  return {fmt::format(R"toml(gravity = [0, 0, 0]
[ground.marker.o]
[body.a]
mass = {}
inertia = [1, 1, 1]
[body.a.marker.c]
[joint.j]
type = "planar"
from = "ground.o"
to = "a.c"
x = {}
v_y = {}
[constraint.thread]
type = "distance"
from = "ground.o"
to = "a.c"
length = {}
[output]
quantities = ["j.x", "j.y", "thread.tension"]
)toml",
                      m, r, w * r, r),
          [=](double t) -> VectorXd {
            return Vector3d(r * std::cos(w * t), r * std::sin(w * t), m * w * w * r);
          }};
}

}  // namespace flexura::mbs::test
