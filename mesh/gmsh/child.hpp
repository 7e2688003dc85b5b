// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace flexura::mesh {

enum class ChildEnd { finished, crashed, out_of_time };

struct ChildOutcome {
  ChildEnd end = ChildEnd::finished;
  int status = 0;       ///< exit code, or the signal's number when it crashed
  std::string reason;   ///< "stopped with a segmentation fault", "ended with code 3", ...
  std::string result;   ///< all that it wrote to its result descriptor
  std::string log;      ///< the last part of what it printed
  std::string stage;    ///< the last that it said on its progress descriptor
  double waited_s = 0;  ///< for a processor while others had it
};

/// Time for a task of several processes, without what these waited for a processor while others had it: a busy
/// machine takes longer, and refuses nothing.
class Allowance {
 public:
  explicit Allowance(double seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  double spent() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count() - waited_;
  }
  double left() const { return seconds_ - spent(); }
  void give_back(double waited_s) { waited_ += waited_s; }

 private:
  double seconds_, waited_ = 0.0;
  std::chrono::steady_clock::time_point start_;
};

/// Runs `program` with `input` on its standard input, until it ends or `limit_s` seconds have passed, what it waited for a
/// processor not counted; then it is killed.  No shell, no temporary files: input, log and result are anonymous memory files, which vanish
/// with their descriptors.  Lines "fraction<tab>stage" on the progress descriptor go to `progress`; when that
/// throws, the child is killed too.  Throws std::runtime_error where no process can be started.
ChildOutcome run_child(const std::filesystem::path& program, const std::string& input, double limit_s,
                       const std::function<void(std::string_view, double)>& progress);

}  // namespace flexura::mesh
