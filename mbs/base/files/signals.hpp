// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

/// What happens to unfinished files, and to standard streams, when a program is told to end.
namespace flexura::files {

/// For the start of a program.  A signal that ends it (SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU) first
/// removes its unfinished files; a reader of our output who goes (SIGPIPE) and a file that becomes too large
/// (SIGXFSZ) are errors of the write, not ends without a word.  Standard streams that are closed are opened
/// onto nothing, so that no file of ours takes their place.
void prepare_process();

/// A file that must not outlive the process while this object lives; a signal removes it.
class Unfinished {
 public:
  explicit Unfinished(const std::filesystem::path& file);  ///< absolute
  ~Unfinished();
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

 private:
  struct Slot;
  friend void remove_unfinished() noexcept;
  Slot* slot_;
};

/// While it lives, signals that end the program do so later: between the making of a file and its Unfinished.
class HeldBack {
 public:
  HeldBack();
  ~HeldBack();
  HeldBack(const HeldBack&) = delete;
  HeldBack& operator=(const HeldBack&) = delete;
};

/// While it lives, SIGINT, SIGTERM and SIGHUP ask for a clean end instead.  A second SIGINT ends the program
/// at once.  SIGHUP stays ignored where it was (nohup).
class StopRequests {
 public:
  StopRequests();
  ~StopRequests();
  StopRequests(const StopRequests&) = delete;
  StopRequests& operator=(const StopRequests&) = delete;
  static bool wanted();
  static const char* name();  ///< of the signal, "SIGTERM"; "" without one

 private:
  void (*before_[3])(int);
};

/// Writes what is buffered; throws std::runtime_error where standard output could not be written (a pipe
/// whose reader has gone, a full disk).
void finish_standard_output();

}  // namespace flexura::files
