// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/math/spatial.hpp"

/// Position and orientation of a frame in a mechanism file: of a marker, a body, a subsystem.
namespace flexura::mbs {

/// The keys of the frame's pose in another's `axes`; `of`: what its origin is.
std::vector<input::Key> pose_keys(const std::string& of, const std::string& axes);
/// Their names.
const std::vector<std::string>& pose_key_names();
/// Says where it is or how it is turned.
bool has_pose(const input::Section& s);
/// Throws InputError.
Pose read_pose(const input::Section& s);

}  // namespace flexura::mbs
