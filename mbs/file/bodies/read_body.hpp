// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/math/spatial.hpp"

/// Pieces of a body's table in the mechanism file.  All throw InputError.
namespace flexura::mbs {

/// Refuses, all at once, what says nothing of a body made as this one is: mass, center and inertia beside a superelement or a
/// beam; what is about deformation where there is no superelement.
void refuse_keys_of_others(const input::Section& s);

/// mass, center and inertia.
RigidInertia read_inertia(const input::Section& s);

/// The body's [[shape]] tables as mbs/view takes them.
std::string shapes_json(const input::Section& s);

}  // namespace flexura::mbs
