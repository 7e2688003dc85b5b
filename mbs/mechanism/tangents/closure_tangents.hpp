// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/kinematics/kinematics.hpp"

/// Coordinates of joints that close loops: what they depend on is the relative motion of their frames.
namespace flexura::mbs {

/// Derivatives of a coordinate (or speed) of a joint that closes a loop by its frames' relative motion:
/// central differences of the joint's own functions.
Eigen::Matrix<double, 1, 12> closure_gradient(const Kinematics& kin, const JointPlace& place, int index,
                                              bool of_speed);

/// S (S^T S)^-1 e of a closure: the wrench of a unit force along its coordinate, see Loads.
Vector6d closure_wrench(const Joint& joint, const Pose& X_FM, int index);
/// Its derivatives by the frames' relative motion (turn, shift and their rates, which do not change it).
Eigen::Matrix<double, 6, 12> closure_wrench_gradient(const Joint& joint, const Pose& X_FM, int index);

}  // namespace flexura::mbs
