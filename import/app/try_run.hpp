// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/model/mechanism.hpp"

namespace flexura::import {

/// Writes the mechanism into a passing folder and runs its first millisecond with the program "flexura" beside this one.  Throws
/// std::runtime_error where it does not run; adds a note where it takes more than 20 s, or the program is not there.
void require_run(Mechanism& mechanism);

}  // namespace flexura::import
