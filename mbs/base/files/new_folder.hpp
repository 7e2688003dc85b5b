// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

namespace flexura::files {

/// A folder that a command writes into, made with those above it where they are not there.  Those that it has made and that are
/// empty at its end are taken away again: what comes to nothing leaves nothing.
class NewFolder {
 public:
  /// Throws std::invalid_argument "FOLDER: no folder of this name can be made: ...; name another" where that fails.
  explicit NewFolder(const std::filesystem::path& folder);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  /// They stay, empty or not.
  void keep() { made_.clear(); }

 private:
  std::vector<std::filesystem::path> made_;  // the innermost last
};

/// Whether a path leads to a place outside of `folder`, whatever links lie on the way.  One that leads nowhere (to itself) does not.
bool leads_out_of(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace flexura::files
