// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

/// Where tests keep their files.
namespace flexura::test {

/// In memory where there is room: the programs bring every output to the disk (mbs/files), which takes a disk
/// some 20 ms a file and shows a test nothing.
inline std::filesystem::path scratch_place() {
  std::error_code none;
  const std::filesystem::path memory = "/dev/shm";
  const std::filesystem::space_info room = std::filesystem::space(memory, none);
  return !none && room.available >= std::uintmax_t{1} << 30 && room.available != std::uintmax_t(-1)
             ? memory
             : std::filesystem::temp_directory_path();
}

}  // namespace flexura::test
