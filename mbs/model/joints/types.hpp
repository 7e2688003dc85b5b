// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/input/schema.hpp"
#include "mbs/model/joint.hpp"

namespace flexura::input {
class Section;
}

/// The types of joints: one file each, listed here and in registry.cpp.
namespace flexura::mbs {

/// How a type of joint stands in the file.
struct JointType {
  std::string name;
  std::string doc;                    ///< for the reference page, with the names other codes use
  std::vector<std::string> synonyms;  ///< accepted too
  std::vector<input::Key> keys;       ///< beyond those every joint has and those of its coordinates
  std::unique_ptr<Joint> (*make)(const input::Section*);  ///< nullptr: all keys at their defaults
};

/// All types, in the order of the reference page.
const std::vector<JointType>& joint_types();

JointType fixed_joint();
JointType revolute_joint();
JointType prismatic_joint();
JointType spherical_joint();
JointType six_dof_joint();
JointType cylindrical_joint();
JointType screw_joint();
JointType planar_joint();
JointType universal_joint();
JointType constant_velocity_joint();
JointType point_on_line_joint();
JointType point_on_plane_joint();
JointType orientation_joint();
JointType parallel_joint();

}  // namespace flexura::mbs
