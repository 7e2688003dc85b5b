// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace flexura::import {

/// A folder of this process for as long as this lives.
class PassingFolder {
 public:
  /// Throws std::runtime_error where it cannot be made.
  PassingFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "flexura-import-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw std::runtime_error(name + ": the folder cannot be made; free space, or set TMPDIR");
    path_ = name;
  }
  ~PassingFolder() {
    std::error_code none;
    std::filesystem::remove_all(path_, none);
  }
  PassingFolder(const PassingFolder&) = delete;
  PassingFolder& operator=(const PassingFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace flexura::import
