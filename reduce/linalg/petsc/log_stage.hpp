// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace flexura::linalg {

/// A stage of PETSc's table of where time goes (-log_view), from construction to destruction.  Does nothing
/// where PETSc is not running.
class LogStage {
 public:
  explicit LogStage(const char* name);
  ~LogStage();
  LogStage(const LogStage&) = delete;
  LogStage& operator=(const LogStage&) = delete;
  /// This one ends and another begins.
  void next(const char* name);
};

}  // namespace flexura::linalg
