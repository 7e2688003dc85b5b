// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/resource.h>

#include <chrono>
#include <ctime>
#include <functional>
#include <string_view>

namespace flexura::linalg {

/// Called by long work with the name of the stage and the fraction of it that is done (0 to 1).  May be
/// empty.
using Progress = std::function<void(std::string_view stage, double fraction)>;

/// Calls a progress function if there is one.
inline void report(const Progress& progress, std::string_view stage, double fraction) {
  if (progress) progress(stage, fraction);
}

/// Processor time of this process so far, all threads together: on a busy machine the measure of work.
inline double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Peak resident memory of this process [bytes].
inline double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

/// Wall-clock seconds since construction or the last call of lap().
class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace flexura::linalg
