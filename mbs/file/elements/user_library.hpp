// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/file/elements/element_types.hpp"
#include "mbs/joints/joint.hpp"

/// Elements out of shared libraries: user_element.hpp says what such a library is.
namespace flexura::mbs {

ForceType user_force();
ConstraintType user_constraint();
ControlType user_control();
MeasureType user_measure();

/// type = "user" among the joints: its keys, and its maker.  A library is loaded as long as an element of it
/// lives.
std::vector<input::Key> user_joint_keys();
std::shared_ptr<const Joint> make_user_joint(const std::string& name, const input::Section& section,
                                             const ReadContext& context);

}  // namespace flexura::mbs
