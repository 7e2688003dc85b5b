// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>

#include "mbs/base/files/place.hpp"

/// The files that a command reads, so that none of them becomes its output.  Every reader notes what it
/// opens. A library that is used by itself may overwrite what it has read: nothing is noted before
/// guard_inputs().
namespace flexura::files {

/// From now on inputs are noted and outputs are held against them.  For the start of a program.
void guard_inputs();

/// Throws std::invalid_argument where what is to be read is a device or a pipe: reading it may wait for ever,
/// or never end.
void require_no_device(const std::filesystem::path& file);

/// Notes a file that is read, and requires that it is no device.  Throws std::invalid_argument where it is one that the command is going to
/// write; files that it has written itself may be read again.
void note_input(const std::filesystem::path& file);

/// From now on to read this file makes it no input: one that this process has made, or an output's older one that it looks at before
/// it is replaced.
void note_own(const std::filesystem::path& file);

/// The name under which this file was read; nothing where it was not, or does not exist.
std::optional<std::filesystem::path> input_like(const std::filesystem::path& file);

}  // namespace flexura::files
