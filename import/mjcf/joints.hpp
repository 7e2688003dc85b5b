// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/mjcf/scene.hpp"

namespace flexura::import::mjcf {

/// A <joint> or <freejoint> with its defaults, as it stands in the body's frame at the start: F and M both at `X_BF` * its own
/// place.  Parent and child are left open.
struct BodyJoint {
  tree::Joint joint;
  JointInfo info;
};
BodyJoint read_joint(const Node& element, const Model& model, const Pose& X_BF, Findings& findings);

/// solref as angular frequency [rad/s] and damping ratio of what is held.
std::pair<double, double> stop_law(const std::vector<double>& solref);

/// Whether "limited" and the like ("auto" is true where there is a range) say so.
bool is_limited(const Node& element, const char* limited, const char* range, const Compiler& compiler,
                Findings& findings);

}  // namespace flexura::import::mjcf
