// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/solver/integrators/integrator.hpp"
#include "mbs/solver/position/projection.hpp"
#include "mbs/solver/position/row_watch.hpp"
#include "mbs/solver/run/energy.hpp"

/// Whether rows left out as redundant begin to say something else on the way (row_watch.hpp).
namespace flexura::mbs {

class ContradictionWatch {
 public:
  /// `is_motion`: rates count, too; equilibria under moving drives are at rest.
  ContradictionWatch(const Equations& eq, const SolverOptions& options, bool is_motion);

  void begin(const State& s) { rows_.begin(s); }
  void change_rows(const State& s) {
    rows_.change_rows(s);
    closer_.forget_factors();
  }
  bool watches() const { return rows_.watches(); }
  /// At a time within the integrator's last step.  What Newton's method left of the kept rows is not theirs.
  bool contradicts(double t, Integrator& integrator);
  /// The last time of the step at which they agree, where they contradict at its end; complaint() says what it is about.
  double last_agreement(double t_begin, double t_end, Integrator& integrator);
  const std::string& complaint() const { return complaint_; }

 private:
  RowWatch rows_;
  LoopCloser closer_;
  RowWatch::Judge judge_;
  double allowed_;
  Instant at_;
  std::string complaint_;
};

}  // namespace flexura::mbs
