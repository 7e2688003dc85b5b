// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/stage_lines.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>

#include "mbs/base/terminal/harmless_stream.hpp"

namespace flexura::reduce {

StageLines::StageLines(std::FILE* stream, bool quiet)
    : StageLines(stream, quiet, isatty(terminal::descriptor_of(stream)) != 0, [] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
      }) {}

StageLines::StageLines(std::FILE* stream, bool quiet, bool is_terminal, Clock clock)
    : stream_(stream), quiet_(quiet || is_terminal), clock_(std::move(clock)) {}

void StageLines::operator()(std::string_view stage, double fraction) {
  if (quiet_) return;
  if (stage != stage_) {
    finish();
    stage_ = stage;
    start_ = clock_();
    next_ = kFirst;
    return;
  }
  const double age = clock_() - start_;
  if (age < next_) return;
  fmt::print(stream_, "{}: {:.0f} s, {:.0f} % done\n", stage_, age, 100.0 * fraction);
  std::fflush(stream_);
  while (next_ <= age) next_ *= 2.0;
}

void StageLines::finish() {
  if (quiet_ || stage_.empty()) return;
  const double age = clock_() - start_;
  if (age >= kFirst) {
    fmt::print(stream_, "{}: {:.0f} s, done\n", stage_, age);
    std::fflush(stream_);
  }
  stage_.clear();
}

}  // namespace flexura::reduce
