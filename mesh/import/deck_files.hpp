// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

namespace flexura::mesh {

/// The files of a deck that includes others, and their names for messages.
class DeckFiles {
 public:
  /// `names` keeps the names for as long as messages refer to them; `keyword`: what includes a file.
  DeckFiles(std::set<std::string>& names, std::string keyword)
      : names_(names), keyword_(std::move(keyword)) {}

  /// Opens a file that is `depth` files deep and notes it as an input.  Throws std::invalid_argument where it cannot be read, or
  /// files include one another.
  std::ifstream open(const std::filesystem::path& path, int depth);
  /// Its name, which stays.
  const std::string* name(const std::filesystem::path& path) { return &*names_.insert(path.string()).first; }

 private:
  std::set<std::string>& names_;
  std::string keyword_;
  int n_files_ = 0;
  std::uintmax_t bytes_read_again_ = 0;
};

}  // namespace flexura::mesh
