// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

/// A program run as a child and measured by the kernel.
namespace flexura::study {

struct ChildOutcome {
  int exit_code = -1;        ///< 128 + signal where a signal ended it
  bool timed_out = false;    ///< it was ended at the time limit
  double wall = 0.0;         ///< [s], from start to end
  double cpu = 0.0;          ///< [s], user and system time
  double peak_memory = 0.0;  ///< [B], largest resident set; not less than that of this process when it starts
  std::string out, err;      ///< what it printed
};

struct TimeLimit {
  double seconds = std::numeric_limits<double>::infinity();
  bool of_processor = false;  ///< it is processor time; by the clock it is ten times as much then
};

/// This process has been told to end; the child has ended.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Names of this process's passing files begin or go on with this: "by-HOST-PROCESS.".
std::string scratch_mark();
/// Removes what processes of this machine that are no more have left under their marks in `scratch`.
void remove_scratch_left(const std::filesystem::path& scratch);

/// Runs command[0] with the other words, without a shell; `scratch` is a folder for what it prints.  Beyond
/// the limit it is ended; so it is when this process ends, however, or is told to
/// (files::StopRequests).  `watch` is called about ten times a second with the file that takes what it prints as errors.
/// Throws std::runtime_error when it cannot be started, and Interrupted.
ChildOutcome run_child(const std::vector<std::string>& command, const std::filesystem::path& scratch,
                       TimeLimit limit = {},
                       const std::function<void(const std::filesystem::path& err)>& watch = {});

}  // namespace flexura::study
