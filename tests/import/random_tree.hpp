// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <kdl/tree.hpp>
#include <random>
#include <string>
#include <vector>

#include "import/model/mechanism.hpp"

/// Random trees of bodies, which tests write down in a format of others, and what KDL says of their motion.
namespace flexura::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double real(double low, double high) { return std::uniform_real_distribution<>(low, high)(engine_); }
  int whole(int below) { return std::uniform_int_distribution<>(0, below - 1)(engine_); }
  bool chance(double p) { return real(0.0, 1.0) < p; }
  Vector3d point(double size) { return {real(-size, size), real(-size, size), real(-size, size)}; }
  Vector3d direction() { return (point(1.0) + Vector3d(0, 0, 1e-3)).normalized(); }
  Matrix3d axes() { return Eigen::AngleAxisd(real(-3.0, 3.0), direction()).toRotationMatrix(); }

 private:
  std::mt19937 engine_;
};

/// Along or about `axis` through `point`, both in the body's frame.
struct DrawnJoint {
  std::string name;
  bool slides = false;
  Vector3d point = Vector3d::Zero(), axis = Vector3d::UnitZ();
  double zero = 0.0;  ///< coordinate where the file places the bodies
  double stiffness = 0.0, rest = 0.0, damping = 0.0, armature = 0.0;
  double q = 0.0, v = 0.0;  ///< state in which it is judged
};

struct DrawnBody {
  std::string name;
  int parent = -1;
  Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity();  ///< where the file places it
  std::vector<DrawnJoint> joints;                          ///< from the parent on; none: fixed
  double mass = 0.0;
  Vector3d center = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Zero();  ///< about the centre, axes of the body
};

struct DrawnTree {
  std::vector<DrawnBody> bodies;
  Vector3d gravity = {0.0, 0.0, -9.81};

  double mass() const;
  int freedoms() const;
};

/// `most_joints` of one body.
DrawnTree draw_tree(Dice& dice, int most_joints);

std::string numbers(const Vector3d& v);
std::string numbers(const std::vector<double>& v);

/// Starts the mechanism in the state of the joints and compares what it says of their accelerations with KDL: recursive Newton-Euler with these
/// must give the forces on the coordinates.  `others` are forces beside springs, dampers and armatures, in the order of the joints.
/// Also the sum of the masses, and the degrees of freedom.  Returns what is wrong.
std::string judge(const import::Mechanism& mechanism, const DrawnTree& tree,
                  const std::vector<double>& others = {});

/// x' = R x + p as a pose of roll, pitch and yaw, R = R_z R_y R_x.
Vector3d roll_pitch_yaw(const Matrix3d& R);

}  // namespace flexura::test
