// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/mechanism/motion/tree_motion.hpp"
#include "mbs/mechanism/topology/coordinates.hpp"

namespace flexura::mbs {

/// Puts the rotation of a joint in the tree, a quaternion, where its drive wants it, and its speed.
void put_rotation(const DrivenRotation& wanted, const JointPlace& place, Eigen::VectorXd& p,
                  Eigen::VectorXd& v);

/// Positions and velocities as a description gives them: a guess, to be assembled.
class StartValues {
 public:
  StartValues(const Topology& tree, const TreeMotion& kinematics, const Coordinates& coordinates);

  Eigen::VectorXd p, v;
  std::vector<bool> given_p, given_v;  ///< entries that the user gave

  /// Puts what drives by time want at t in place of what they want at 0.
  void drive_at(double t, Eigen::VectorXd& at_p, Eigen::VectorXd& at_v) const;

 private:
  void follow_split_joints();
  /// Sets the coordinates of b's joint so that the body stands at X_WB; `motion` knows the markers of the body before it.
  void stand_at(int b, const Pose& X_WB, const Motion& motion);

  const Topology& tree_;
  const TreeMotion& kinematics_;
};

}  // namespace flexura::mbs
