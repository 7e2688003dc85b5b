// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/watch/contradiction_watch.hpp"

namespace flexura::mbs {

ContradictionWatch::ContradictionWatch(const Equations& eq, const SolverOptions& options, bool is_motion)
    : rows_(eq),
      closer_(eq, options),
      judge_(is_motion ? RowWatch::Judge::all : RowWatch::Judge::positions),
      allowed_(RowWatch::allowed(options.tolerance)) {}

bool ContradictionWatch::contradicts(double t, Integrator& integrator) {
  integrator.interpolate(t, at_.state, at_.v_dot);
  if (rows_.look(at_.state, judge_).left_out <= 1.0) return false;
  closer_.close(at_.state);
  return rows_.look(at_.state, judge_).contradicts(allowed_);
}

double ContradictionWatch::last_agreement(double t_begin, double t_end, Integrator& integrator) {
  constexpr int kHalvings = 30;
  double agrees = t_begin, contradictory = t_end;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (agrees + contradictory);
    (contradicts(middle, integrator) ? contradictory : agrees) = middle;
  }
  contradicts(t_end, integrator);
  complaint_ = rows_.complaint(t_end, agrees, allowed_);
  return agrees;
}

}  // namespace flexura::mbs
