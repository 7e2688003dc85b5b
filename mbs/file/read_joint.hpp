// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/file/elements/read_context.hpp"

namespace flexura::mbs {

/// A table [joint.NAME] or, `is_connection`, [connection.NAME]: its type, markers and values at the start.
/// Throws InputError.
JointDescription read_joint(const std::string& name, const input::Section& section,
                            const ReadContext& context, bool is_connection);

/// Its drives, once the names of controls are known, whose states they may follow.
void read_drives(const input::Section& section, const ReadContext& context, JointDescription& joint);

/// The keys of these drives for a type of joint.
std::vector<input::Key> drive_keys(const Joint& joint);
/// ", of M as seen from F, in the axes of F" of a component along x, y, z; of a quaternion what it turns.
std::string component_of(const std::string& coordinate);

}  // namespace flexura::mbs
