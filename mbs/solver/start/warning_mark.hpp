// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace flexura::mbs {

/// Begins those of a started mechanism's notes that make the start doubtful: warnings.
inline const std::string warning_mark = "warning: ";

}  // namespace flexura::mbs
