// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>

#include "mbs/files/signals.hpp"

namespace flexura::files {

/// Another process is writing this output.
class Busy : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The right of one process to write a file: an exclusive lock on FOLDER/.NAME.lock, which holds the
/// process's number and is removed with the lock.  The kernel gives the lock back when the process dies,
/// however it dies.  To make this file also tells whether the folder takes files.
class Lock {
 public:
  /// `place` as of place_of(), `output` as the user named it.  Throws Busy where another process
  /// holds it, std::invalid_argument where the folder takes no files, std::runtime_error where the disk is
  /// full.
  Lock(const std::filesystem::path& place, const std::filesystem::path& output);
  ~Lock();
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::optional<Unfinished> unfinished_;
};

}  // namespace flexura::files
