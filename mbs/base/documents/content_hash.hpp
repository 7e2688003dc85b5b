// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

/// Names for results by what they were made from: 128 bits of XXH3 over program, files and overrides.  Two
/// different contents share a name with probability 2^-128 per pair, as long as nobody seeks to make them.
namespace flexura::input {

struct InputFile {
  std::string named;  ///< as it is called by the file that names it; "" for the first
  std::filesystem::path path;
};

/// An input file, and every file that one of its quoted texts names relative to its folder: CAD files,
/// superelements, tables; subsystems and parts with those that they name, decks with what they include.  A
/// schema is not needed, so no key that names a file can be forgotten.  Throws std::runtime_error where one
/// cannot be read.
std::vector<InputFile> input_files(const std::filesystem::path& file);

class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(const ContentHash&) = delete;
  ContentHash& operator=(const ContentHash&) = delete;

  /// The text and its length, so that ("ab", "c") and ("a", "bc") differ.
  ContentHash& add(std::string_view text);
  /// The content of a file, not its name.  Throws std::runtime_error when it cannot be read.
  ContentHash& add_file(const std::filesystem::path& file);
  /// All of input_files(file): their contents, and the names by which they are called.
  ContentHash& add_input_file(const std::filesystem::path& file);

  std::string hex() const;  ///< 32 digits

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::input
