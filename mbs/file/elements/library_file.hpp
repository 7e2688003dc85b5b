// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace flexura::mbs {

/// Why the loader would not survive this shared library, or nothing.  The loader maps what the file's header
/// promises: a file that is cut short ends the program with SIGBUS.  So the header is held against the file,
/// and loading is tried in a process of its own first (once for each state of the file).
std::string why_not_loadable(const std::filesystem::path& library);

}  // namespace flexura::mbs
