// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace flexura::mbs {

/// A state file that a run is to go on from (state_file.hpp) must be as it was written: its checksum fits.  States
/// that are only started from may be changed by hand.  Throws std::invalid_argument, one sentence.
void require_whole_continuation(const std::filesystem::path& path);

}  // namespace flexura::mbs
