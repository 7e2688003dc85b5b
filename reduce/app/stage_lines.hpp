// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdio>
#include <functional>
#include <string>
#include <string_view>

namespace flexura::reduce {

/// Stages of long work as lines, for a log: where the stream is no terminal (a terminal has terminal::Progress), a stage
/// that lasts 10 s says so, again each time its age has doubled, and when it ends.
class StageLines {
 public:
  using Clock = std::function<double()>;  ///< seconds

  StageLines(std::FILE* stream, bool quiet);
  /// For tests: what `is_terminal` and the time are.
  StageLines(std::FILE* stream, bool quiet, bool is_terminal, Clock clock);

  /// `fraction` of the stage done, 0 to 1.
  void operator()(std::string_view stage, double fraction);
  /// Ends the last stage.
  void finish();

 private:
  static constexpr double kFirst = 10.0;  // [s]

  std::FILE* stream_;
  bool quiet_;
  Clock clock_;
  std::string stage_;
  double start_ = 0.0, next_ = kFirst;
};

}  // namespace flexura::reduce
