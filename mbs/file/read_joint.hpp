// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/file/elements/read_context.hpp"

namespace flexura::mbs {

/// A table [joint.NAME] or, `is_connection`, [connection.NAME]: its type, markers, values at the start and
/// drives. Throws InputError.
JointDescription read_joint(const std::string& name, const input::Section& section,
                            const ReadContext& context, bool is_connection);

}  // namespace flexura::mbs
