// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/model/joint.hpp"

/// The types of joints: one file each, listed here and in registry.cpp.
namespace flexura::mbs {

JointType fixed_joint();
JointType revolute_joint();
JointType prismatic_joint();
JointType spherical_joint();
JointType six_dof_joint();

}  // namespace flexura::mbs
