// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "import/urdf/robot.hpp"

/// The robot at its start position.
namespace flexura::import::urdf {

/// Coordinate of every joint at the start: 0, the nearest limit where 0 is beyond it, what mimic asks for.
std::vector<double> start_coordinates(const Robot& robot);

/// Motion of a joint of one coordinate by q, of others none.
Pose motion_of(const Joint& joint, double q);

/// Makes a joint of one coordinate a fixed one that stands at q, which becomes 0.
void fix(Joint& joint, double& q);

/// Where the links stand; the root at the origin.
std::vector<Pose> link_poses(const Robot& robot, const std::vector<double>& q);

/// H (n x n) in the coordinates of the movable joints that no drive holds, in the order of `robot.order`, by composite bodies:
/// H_ij = S_i^T I_c S_j with the composite inertia I_c behind the outer one of i and j (Featherstone, Rigid Body Dynamics
/// Algorithms, section 6.2).  The root stands.
struct StartMass {
  Eigen::MatrixXd H;
  Eigen::VectorXd size;       ///< sum of the magnitudes that H_ii is made of: round-off is 1e-16 of it
  std::vector<int> joint_of;  ///< of each coordinate
};
StartMass start_mass(const Robot& robot, const std::vector<double>& q);

/// A joint that moves nothing with inertia, or nothing apart from what the joints before it move.
struct Idle {
  int joint = -1;
  bool moves_nothing = false;
};
/// At the start position; joints that mimic count with the one that they follow, or (`alone`) all by themselves.
std::vector<Idle> idle_joints(const Robot& robot, const std::vector<double>& q, bool alone = false);

}  // namespace flexura::import::urdf
