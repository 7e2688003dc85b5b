// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <string>

namespace flexura::properties {

/// Links of lengths a, b, a, b and twists alpha, beta, alpha, beta with sin(alpha) / a = sin(beta) / b (G. T. Bennett, Engineering 76
/// (1903) 777): opposite angles are equal and opposite, and tan(theta_1 / 2) tan(theta_2 / 2) = sin((beta + alpha) / 2) /
/// sin((beta - alpha) / 2).  The last link is the ground.
struct Bennett {
  double alpha, beta, a;
  double b() const { return a * std::sin(beta) / std::sin(alpha); }
  double product() const { return std::sin(0.5 * (beta + alpha)) / std::sin(0.5 * (beta - alpha)); }
  double length(int link) const { return link == 1 ? b() : a; }
  double twist(int link) const { return link == 1 ? beta : alpha; }
  std::array<double, 3> angles(double theta) const {
    // Without the pole at pi; continuous over turns up to 2 pi, which rotations do not see.
    const double second = 2.0 * std::atan2(product() * std::cos(0.5 * theta), std::sin(0.5 * theta));
    return {theta, second, -theta};
  }
  std::array<Eigen::Isometry3d, 3> poses(double theta) const {
    std::array<Eigen::Isometry3d, 3> out;
    Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
    const std::array<double, 3> q = angles(theta);
    for (int k = 0; k < 3; ++k) {
      at.rotate(Eigen::AngleAxisd(q[static_cast<std::size_t>(k)], Eigen::Vector3d::UnitZ()));
      out[static_cast<std::size_t>(k)] = at;
      at.translate(Eigen::Vector3d(length(k), 0, 0));
      at.rotate(Eigen::AngleAxisd(twist(k), Eigen::Vector3d::UnitX()));
    }
    return out;
  }
  // A rod of 1 kg/m in each link: twice the kinetic energy at 1 rad/s, by differences of order 4.
  double inertia(double theta) const {
    constexpr double h = 1e-3;
    const auto at = [&](double d) { return poses(theta + d); };
    const auto m2 = at(-2 * h), m1 = at(-h), p1 = at(h), p2 = at(2 * h), now = at(0.0);
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double l = length(k);
      const Eigen::Vector3d centre(0.5 * l, 0, 0);
      const auto rate = [&](const auto& of) {
        return (8.0 * (of(p1[i]) - of(m1[i])) - (of(p2[i]) - of(m2[i]))).eval() / (12.0 * h);
      };
      const Eigen::Vector3d v =
          rate([&](const Eigen::Isometry3d& x) -> Eigen::Vector3d { return x * centre; });
      const Eigen::Matrix3d R_dot =
          rate([](const Eigen::Isometry3d& x) -> Eigen::Matrix3d { return x.linear(); });
      const Eigen::Matrix3d W = now[i].linear().transpose() * R_dot;
      const Eigen::Vector3d w(W(2, 1), W(0, 2), W(1, 0));
      sum +=
          l * v.squaredNorm() + l * 1e-3 * w.x() * w.x() + l * l * l / 12.0 * (w.y() * w.y() + w.z() * w.z());
    }
    return sum;
  }
};

/// `first`: lines of its first joint, that say how it moves.
inline std::string text_of(const Bennett& linkage, double theta, const std::string& first) {
  std::string text = fmt::format(
      "gravity = [0,0,0]\n[ground.marker.g]\nposition = [{},0,0]\naxis = [0,{},{}]\nx_axis = [1,0,0]\n",
      -linkage.b(), std::sin(linkage.beta), std::cos(linkage.beta));
  const std::array<double, 3> q = linkage.angles(theta);
  for (int k = 0; k < 3; ++k) {
    const double l = linkage.length(k), twist = linkage.twist(k);
    text += fmt::format(R"(
[body.b{0}]
mass = {1}
center = [{2},0,0]
inertia = [{3},{4},{4}]
[body.b{0}.marker.d]
position = [{1},0,0]
axis = [0,{5},{6}]
x_axis = [1,0,0]
[joint.j{0}]
type = "revolute"
from = "{7}"
to = "b{0}"
)",
                        k, l, 0.5 * l, 1e-3 * l, l * l * l / 12.0, -std::sin(twist), std::cos(twist),
                        k == 0 ? "ground" : fmt::format("b{}.d", k - 1));
    text += k == 0 ? first : fmt::format("angle = \"{} rad\"\n", q[static_cast<std::size_t>(k)]);
  }
  return text + "[joint.j3]\ntype = \"revolute\"\nfrom = \"b2.d\"\nto = \"ground.g\"\n";
}

}  // namespace flexura::properties
