// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mbs/file/elements/read_context.hpp"
#include "mbs/kinematics/body_path.hpp"

namespace flexura::mbs {

/// The key `path` of what travels along a body, and its reader.  Throws InputError: fewer than two markers, markers of
/// several bodies, two neighbours in one place.
input::Key path_key();
std::shared_ptr<const BodyPath> read_path(const input::Section& section, const ReadContext& context);

}  // namespace flexura::mbs
