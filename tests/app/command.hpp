// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// Runs the built programs as a user does, without a shell between.
namespace flexura::test {

struct Outcome {
  int exit_code = -1;  ///< -1 where a signal ended it
  std::string out, err;
};

/// Runs PROGRAM (a name in the build's bin folder) with these arguments.
Outcome run(const std::string& program, const std::vector<std::string>& arguments);

/// A folder of its own for one test, removed at the end.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }
  /// Writes a text file into the folder.
  std::filesystem::path write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

std::string read_text(const std::filesystem::path& file);
/// `text` with the first `from` replaced; throws std::logic_error when there is none (so that a test cannot
/// rot).
std::string replaced(std::string text, const std::string& from, const std::string& to);

}  // namespace flexura::test
