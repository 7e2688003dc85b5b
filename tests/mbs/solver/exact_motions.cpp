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

ExactMotion shaken_spring(const ShakenSpring& spring) {
  constexpr double g = 9.81;
  const auto [w, zeta, y0, A, W, cart] = spring;
  const double F = A * W * W, stiff = w * w - W * W, damped = 2.0 * zeta * w * W,
               D = stiff * stiff + damped * damped, P = F * stiff / D, Q = -F * damped / D,
               rest = -g / (w * w), w_d = w * std::sqrt(1.0 - zeta * zeta), C = y0 - rest - Q,
               S = (zeta * w * C - P * W) / w_d;
  const std::string moving = fmt::format(
      "[body.g]\nmass = 2\ninertia = [0.1, 0.1, 0.1]\n[body.g.marker.m]\n[joint.g]\ntype = "
      "\"prismatic\"\n"
      "from = \"ground.m\"\nto = \"g.m\"\ndrive = \"{}*sin({}*t)\"\n",
      A, W);
  const std::string soft = R"toml([body.soft]
mass = 3
inertia = [0.1, 0.1, 0.1]
[body.soft.marker.m]
[joint.soft]
type = "prismatic"
from = "ground.m"
to = "soft.m"
speed = 2
[force.cart]
type = "joint_spring_damper"
joint = "soft"
stiffness = 30
)toml";
  return {fmt::format(R"toml([ground.marker.m]
[ground.marker.p]
axis = [0, 1, 0]
{}{}[body.a]
mass = 1
inertia = [0.1, 0.1, 0.1]
[body.a.marker.m]
[joint.j]
type = "prismatic"
from = "{}.m"
to = "a.m"
position = {}
[force.s]
type = "joint_spring_damper"
joint = "j"
stiffness = {}
damping = {}
[body.b]
mass = 1
inertia = [0.1, 0.1, 0.1]
center = [0.3, 0, 0]
[body.b.marker.p]
axis = [0, 1, 0]
[joint.p]
type = "revolute"
from = "ground.p"
to = "b.p"
[output]
quantities = ["s.force"]
)toml",
                      A != 0.0 ? moving : "", cart ? soft : "", A != 0.0 ? "g" : "ground", y0, w * w,
                      2.0 * zeta * w),
          [=](double t) -> VectorXd {
            const double decay = std::exp(-zeta * w * t), c = std::cos(w_d * t), s = std::sin(w_d * t),
                         y = rest + P * std::sin(W * t) + Q * std::cos(W * t) + decay * (C * c + S * s),
                         v = W * (P * std::cos(W * t) - Q * std::sin(W * t)) +
                             decay * (w_d * (S * c - C * s) - zeta * w * (C * c + S * s));
            return Eigen::Matrix<double, 1, 1>(-w * w * y - 2.0 * zeta * w * v);
          }};
}

}  // namespace flexura::mbs::test
