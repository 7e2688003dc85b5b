// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "mbs/base/files/signals.hpp"

namespace flexura::files {

/// Another process is writing this output.
class Busy : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The right of one process to write a file: an exclusive lock on FOLDER/.NAME.lock, which holds the
/// process's number and its private files (output.hpp), and is removed with the lock.  The kernel gives the
/// lock back when the process dies, however it dies; what it left is read from there by the next one, and
/// removed.  To make this file also tells whether the folder takes files.
class Lock {
 public:
  /// `place` as of place_of(), `output` as the user named it.  Throws Busy where another process
  /// holds it, std::invalid_argument where the folder takes no files, std::runtime_error where the disk is
  /// full or broken.
  Lock(const std::filesystem::path& place, const std::filesystem::path& output);
  ~Lock();
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

  /// A private file of this output has been made.  0, or what went wrong.
  int note(const std::filesystem::path& part);
  /// Removes what a killed holder has left, except what this process reads.  At the first output, and at the
  /// end of the claim in any case: by then the inputs are known.
  void remove_left();

 private:
  void unlink_left() noexcept;

  std::filesystem::path file_;
  int descriptor_ = -1;
  std::string noted_;                        ///< the last line of it
  std::vector<std::filesystem::path> left_;  ///< by a holder that was killed
  std::optional<Unfinished> unfinished_;     ///< once nothing is left: until then the file knows of it
};

}  // namespace flexura::files
