// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>

/// Where files lie, and which names are one and the same file.
namespace flexura::files {

/// A file by what it is, whatever it is called: hard and symbolic links to one file have one identity.
struct Identity {
  std::uintmax_t device = 0, inode = 0;
  auto operator<=>(const Identity&) const = default;
};

/// Nothing where there is no such file.  Links are followed.
std::optional<Identity> identity_of(const std::filesystem::path& file);

/// Where an output of this name comes to lie: absolute, links followed.  Throws std::invalid_argument, one
/// sentence, where no file can be: a folder that is not there, a folder, device or pipe of this name, a file
/// that is read-only.
std::filesystem::path place_of(const std::filesystem::path& output);

/// For commands that add endings to a name.  Throws std::invalid_argument where it is no beginning of a file's
/// name: "", ".", "folder/", a device.
void require_stem(const std::filesystem::path& stem);

/// Throws std::runtime_error where the file system that holds `folder` has less room than `bytes`, or files
/// may not become so large (ulimit -f).
void require_room(const std::filesystem::path& output, const std::filesystem::path& folder, double bytes);

}  // namespace flexura::files
