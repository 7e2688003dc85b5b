// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <stdexcept>

#include "mbs/model/joints/types.hpp"

namespace flexura::mbs {

const std::vector<JointType>& joint_types() {
  static const std::vector<JointType> types = {
      fixed_joint(),         revolute_joint(),       prismatic_joint(),
      cylindrical_joint(),   screw_joint(),          spherical_joint(),
      universal_joint(),     planar_joint(),         constant_velocity_joint(),
      point_on_line_joint(), point_on_plane_joint(), orientation_joint(),
      parallel_joint(),      six_dof_joint(),
  };
  return types;
}

std::unique_ptr<Joint> make_joint(const std::string& type) {
  for (const JointType& t : joint_types())
    if (t.name == type || std::ranges::find(t.synonyms, type) != t.synonyms.end()) return t.make(nullptr);
  throw std::invalid_argument("there is no joint type \"" + type + "\"");
}

}  // namespace flexura::mbs
