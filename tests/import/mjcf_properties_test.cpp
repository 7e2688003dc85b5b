// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Random MJCF models move as KDL says, however they are spelt: units of angles, orientations, classes of defaults, frames, replicas.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "import/mjcf/convert.hpp"
#include "tests/app/command.hpp"
#include "tests/import/random_tree.hpp"

namespace flexura::test {
namespace {

import::Mechanism read_mjcf(const Folder& folder, const std::string& text,
                            const std::string& name = "m.xml"){const auto file = folder.write(name, text);
import::Findings findings(file);
return import::mjcf::to_mechanism(file, {}, findings);
}  // namespace

/// Writes the tree in one of the many ways that MJCF has; joints of a class get what the class says.
class Speller {
 public:
  explicit Speller(Dice& dice) : dice_(dice), degree_(dice.chance(0.5)) {}

  std::string spell(DrawnTree& tree) {
    std::string worldbody;
    for (std::size_t i = 0; i < tree.bodies.size(); ++i)
      if (tree.bodies[i].parent < 0) worldbody += body(tree, i);
    return fmt::format(
        "<mujoco model=\"random\">\n<compiler angle=\"{}\" eulerseq=\"XYZ\"/>\n<option gravity=\"{}\"/>\n"
        "<default><default class=\"soft\"><joint stiffness=\"3\" damping=\"0.5\" armature=\"0.2\"/>"
        "<default class=\"softer\"><joint stiffness=\"1.5\"/></default></default></default>\n"
        "<worldbody>{}</worldbody>\n</mujoco>\n",
        degree_ ? "degree" : "radian", numbers(tree.gravity), worldbody);
  }

 private:
  double angle(double rad) const { return degree_ ? rad * 180.0 / std::numbers::pi : rad; }

  std::string orientation(const Matrix3d& R) {
    const Eigen::Quaterniond q(R);
    const Eigen::AngleAxisd aa(R);
    const Vector3d zyx = roll_pitch_yaw(R);
    switch (dice_.whole(4)) {
      case 0:
        return fmt::format("quat=\"{}\"",
                           numbers(std::vector<double>{2 * q.w(), 2 * q.x(), 2 * q.y(), 2 * q.z()}));
      case 1:
        return fmt::format("axisangle=\"{} {:.17g}\"", numbers(Vector3d(3.0 * aa.axis())), angle(aa.angle()));
      case 2:  // XYZ: about axes that stand, x first
        return fmt::format("euler=\"{}\"",
                           numbers(std::vector<double>{angle(zyx[0]), angle(zyx[1]), angle(zyx[2])}));
      default:
        return fmt::format("xyaxes=\"{} {}\"", numbers(Vector3d(2.0 * R.col(0))),
                           numbers(Vector3d(R.col(1) + 0.3 * R.col(0))));
    }
  }

  std::string joint(DrawnJoint& j) {
    std::string text =
        fmt::format("<joint name=\"{}\" type=\"{}\" pos=\"{}\" axis=\"{}\"", j.name,
                    j.slides ? "slide" : "hinge", numbers(j.point), numbers(Vector3d(2.5 * j.axis)));
    const double unit = j.slides ? 1.0 : angle(1.0);
    if (j.zero != 0.0) text += fmt::format(" ref=\"{:.17g}\"", unit * j.zero);
    text += fmt::format(" springref=\"{:.17g}\"", unit * j.rest);
    if (j.name.ends_with("_0") && dice_.chance(0.2)) {  // from classes
      const bool softer = dice_.chance(0.5);
      j.stiffness = softer ? 1.5 : 3.0;
      j.damping = 0.5;
      j.armature = 0.2;
      return text + fmt::format(" class=\"{}\"/>\n", softer ? "softer" : "soft");
    }
    return text + fmt::format(" stiffness=\"{:.17g}\" damping=\"{:.17g}\" armature=\"{:.17g}\"/>\n",
                              j.stiffness, j.damping, j.armature);
  }

  std::string body(DrawnTree& tree, std::size_t i) {
    DrawnBody& b = tree.bodies[i];
    std::string inside =
        fmt::format("<inertial pos=\"{}\" mass=\"{:.17g}\" fullinertia=\"{}\"/>\n", numbers(b.center), b.mass,
                    numbers(std::vector<double>{b.inertia(0, 0), b.inertia(1, 1), b.inertia(2, 2),
                                                b.inertia(0, 1), b.inertia(0, 2), b.inertia(1, 2)}));
    if (dice_.chance(0.5))
      inside += "<geom type=\"box\" size=\"0.1 0.2 0.3\" euler=\"0.1 0.2 0.3\"/><geom size=\"0.1\"/>";
    for (DrawnJoint& j : b.joints) inside += joint(j);
    for (std::size_t k = 0; k < tree.bodies.size(); ++k)
      if (tree.bodies[k].parent == static_cast<int>(i)) inside += body(tree, k);
    // In a frame or not.
    Eigen::Isometry3d X = b.X_PB;
    std::string before, behind;
    if (dice_.chance(0.3)) {
      Eigen::Isometry3d F = Eigen::Isometry3d::Identity();
      F.linear() = dice_.axes();
      F.translation() = dice_.point(0.5);
      before =
          fmt::format("<frame pos=\"{}\" {}>", numbers(Vector3d(F.translation())), orientation(F.linear()));
      behind = "</frame>";
      X = F.inverse() * X;
    }
    return before +
           fmt::format("<body name=\"{}\" pos=\"{}\" {}>\n{}</body>\n", b.name,
                       numbers(Vector3d(X.translation())), orientation(X.linear()), inside) +
           behind;
  }

  Dice& dice_;
  bool degree_;
};

TEST(RandomMjcf, MovesAsKdlSays) {
  const Folder folder;
  for (unsigned seed = 1; seed <= 250; ++seed) {
    Dice dice(seed);
    DrawnTree tree = draw_tree(dice, 3);
    tree.gravity = dice.point(10.0);
    for (DrawnBody& b : tree.bodies)
      for (DrawnJoint& j : b.joints) {
        if (dice.chance(0.3)) j.zero = dice.real(-0.5, 0.5);
        if (dice.chance(0.3)) j.armature = dice.real(0.01, 2.0);
      }
    Speller speller(dice);
    const std::string text = speller.spell(tree);
    const std::string wrong = judge(read_mjcf(folder, text), tree);
    ASSERT_EQ(wrong, "") << "seed " << seed << "\n" << text;
  }
}

// Motors, servos and dampers with gears, tendons of joints with spring, damper and armature: what MuJoCo's documentation says of their
// forces, with all controls at 0.
TEST(RandomMjcf, HasTheForcesOfActuatorsAndTendons) {
  const Folder folder;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Dice dice(1000 + seed);
    DrawnTree tree = draw_tree(dice, 2);
    std::vector<DrawnJoint*> joints;
    for (DrawnBody& b : tree.bodies)
      for (DrawnJoint& j : b.joints) joints.push_back(&j);
    Speller speller(dice);
    std::string text = speller.spell(tree);  // classes are settled now
    std::vector<double> others(joints.size(), 0.0);
    std::string actuators, fixed;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const DrawnJoint& j = *joints[i];
      const double gear = dice.real(-2.0, 2.0), kp = dice.real(1.0, 10.0), kv = dice.real(0.1, 2.0);
      const double length = gear * j.q, rate = gear * j.v;
      const std::string on = fmt::format("joint=\"{}\" gear=\"{:.17g}\"", j.name, gear);
      switch (dice.whole(5)) {
        case 0:
          actuators += fmt::format("<position {} kp=\"{:.17g}\" kv=\"{:.17g}\"/>", on, kp, kv);
          others[i] += gear * (-kp * length - kv * rate);
          break;
        case 1:
          actuators += fmt::format("<velocity {} kv=\"{:.17g}\"/>", on, kv);
          others[i] -= gear * kv * rate;
          break;
        case 2:
          actuators += fmt::format(
              "<general {} biastype=\"affine\" biasprm=\"1.5 {:.17g} {:.17g}\" forcerange=\"-1 1\"/>", on,
              -kp, -kv);
          others[i] += gear * std::clamp(1.5 - kp * length - kv * rate, -1.0, 1.0);
          break;
        case 3:
          actuators += fmt::format("<motor {} ctrlrange=\"1 2\"/>", on);  // 0 is below: clamped to 1
          others[i] += gear * 1.0;
          break;
        default:
          break;
      }
      fixed +=
          fmt::format("<joint joint=\"{}\" coef=\"{:.17g}\"/>", j.name, 0.5 + 0.25 * static_cast<double>(i));
    }
    const double k = dice.real(1.0, 20.0), d = dice.real(0.0, 2.0), free = dice.real(-1.0, 1.0);
    double length = 0.0, rate = 0.0;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      length += (0.5 + 0.25 * static_cast<double>(i)) * joints[i]->q;
      rate += (0.5 + 0.25 * static_cast<double>(i)) * joints[i]->v;
    }
    for (std::size_t i = 0; i < joints.size(); ++i)
      others[i] -= (0.5 + 0.25 * static_cast<double>(i)) * (k * (length - free) + d * rate);
    text = replaced(
        text, "</mujoco>",
        fmt::format(
            "<actuator>{}</actuator><tendon><fixed name=\"t\" stiffness=\"{:.17g}\" damping=\"{:.17g}\" "
            "springlength=\"{:.17g} {:.17g}\">{}</fixed></tendon></mujoco>",
            actuators, k, d, free, free, fixed));
    const std::string wrong = judge(read_mjcf(folder, text), tree, others);
    ASSERT_EQ(wrong, "") << "seed " << seed << "\n" << text;
  }
}

// Geoms give mass, centre and inertia by closed forms that are written down here once more.
TEST(RandomMjcf, WeighsBodiesByTheirGeoms) {
  const Folder folder;
  const double pi = std::numbers::pi;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Dice dice(2000 + seed);
    DrawnTree tree = draw_tree(dice, 1);
    std::string bodies;
    for (DrawnBody& b : tree.bodies) {
      std::vector<std::tuple<double, Vector3d, Matrix3d>> parts;
      std::string geoms;
      for (int g = 0; g <= dice.whole(3); ++g) {
        const Vector3d s(dice.real(0.05, 0.3), dice.real(0.05, 0.3), dice.real(0.05, 0.3)),
            at = dice.point(0.3);
        const Matrix3d R = dice.axes();
        const Eigen::Quaterniond quat(R);
        const std::string place =
            fmt::format("pos=\"{}\" quat=\"{}\"", numbers(at),
                        numbers(std::vector<double>{quat.w(), quat.x(), quat.y(), quat.z()}));
        double volume = 0.0;
        Vector3d second;  // integrals of x_k^2 over the volume
        std::string shape;
        switch (dice.whole(5)) {
          case 0:
            shape = fmt::format("type=\"box\" size=\"{}\"", numbers(s));
            volume = 8.0 * s.prod();
            second = volume * s.cwiseProduct(s) / 3.0;
            break;
          case 1:
            shape = fmt::format("type=\"ellipsoid\" size=\"{}\"", numbers(s));
            volume = 4.0 / 3.0 * pi * s.prod();
            second = volume * s.cwiseProduct(s) / 5.0;
            break;
          case 2:
            shape = fmt::format("size=\"{:.17g}\"", s.x());
            volume = 4.0 / 3.0 * pi * std::pow(s.x(), 3);
            second = volume * Vector3d::Constant(s.x() * s.x() / 5.0);
            break;
          case 3:
            shape = fmt::format("type=\"cylinder\" size=\"{:.17g} {:.17g}\"", s.x(), s.y());
            volume = 2.0 * pi * s.x() * s.x() * s.y();
            second = volume * Vector3d(s.x() * s.x() / 4.0, s.x() * s.x() / 4.0, s.y() * s.y() / 3.0);
            break;
          default: {
            // int z^2 of two half balls at +-h: ball (r^2/5 + h^2) + 2 h (3/8 r ball / 2) 2
            const double r = s.x(), h = s.y(), tube = 2.0 * pi * r * r * h, ball = 4.0 / 3.0 * pi * r * r * r;
            shape = fmt::format("type=\"capsule\" size=\"{:.17g} {:.17g}\"", r, h);
            volume = tube + ball;
            second = tube * Vector3d(r * r / 4.0, r * r / 4.0, h * h / 3.0) +
                     ball * Vector3d::Constant(r * r / 5.0);
            second.z() += ball * (h * h + 0.75 * r * h);
          }
        }
        double density = 1000.0;
        if (dice.chance(0.3)) {
          density = dice.real(100.0, 3000.0);
          shape += fmt::format(" density=\"{:.17g}\"", density);
        } else if (dice.chance(0.3)) {
          const double mass = dice.real(0.1, 5.0);
          density = mass / volume;
          shape += fmt::format(" mass=\"{:.17g}\"", mass);
        }
        geoms += fmt::format("<geom {} {}/>\n", shape, place);
        const Matrix3d I = Vector3d(second.sum() - second.array()).asDiagonal();
        parts.emplace_back(density * volume, at, density * (R * I * R.transpose()));
      }
      b.mass = 0.0;
      b.center.setZero();
      for (const auto& [m, c, I] : parts) {
        b.mass += m;
        b.center += m * c;
      }
      b.center /= b.mass;
      b.inertia.setZero();
      for (const auto& [m, c, I] : parts) {
        const Vector3d r = c - b.center;
        b.inertia += I + m * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose());
      }
      const Eigen::Quaterniond quat(b.X_PB.linear());
      std::string joints;
      for (const DrawnJoint& j : b.joints)
        joints += fmt::format(
            "<joint name=\"{}\" type=\"{}\" pos=\"{}\" axis=\"{}\" stiffness=\"{:.17g}\" "
            "springref=\"{:.17g}\" damping=\"{:.17g}\"/>\n",
            j.name, j.slides ? "slide" : "hinge", numbers(j.point), numbers(j.axis), j.stiffness, j.rest,
            j.damping);
      b.parent = -1;  // side by side
      bodies +=
          fmt::format("<body name=\"{}\" pos=\"{}\" quat=\"{}\">{}{}</body>\n", b.name,
                      numbers(Vector3d(b.X_PB.translation())),
                      numbers(std::vector<double>{quat.w(), quat.x(), quat.y(), quat.z()}), joints, geoms);
    }
    const std::string text =
        "<mujoco><compiler angle=\"radian\"/><worldbody>" + bodies + "</worldbody></mujoco>";
    const std::string wrong = judge(read_mjcf(folder, text), tree);
    ASSERT_EQ(wrong, "") << "seed " << seed << "\n" << text;
  }
}

}  // namespace flexura::test
}  // namespace flexura::test
