// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/watch/leap_watch.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace flexura::mbs {

namespace {

// Of a run: shorter steps are not looked at.
constexpr double kShortest = 1e-13;

}  // namespace

LeapWatch::LeapWatch(const Equations& eq, const SolverOptions& options)
    : peaks_(eq), duration_(options.end_time - options.start_time) {}

// A first step behind a switch that would have been twice as long as what leads to the next one knows little of what is
// between them, like the impact of a bullet: it is made again, no longer than a part of that.  Where that comes to the same,
// as for a controller's samples, these switches are taken as they come from then on.
bool LeapWatch::over_switches(const StepEnd& end, bool has_history) {
  constexpr double kOfStep = 0.5, kNext = 0.25, kSame = 1e-3;
  if (end.roots.empty()) return false;
  const double h = end.t_end - end.t_begin;
  if (leapt_ && leapt_->roots == end.roots &&
      std::abs(end.t_end - leapt_->t_end) <= kSame * (leapt_->t_end - leapt_->t_begin))
    harmless_.insert(end.roots.begin(), end.roots.end());
  const bool is_known = std::ranges::all_of(end.roots, [&](int k) { return harmless_.contains(k); });
  if (has_history || is_known || !(h < kOfStep * (end.t_tried - end.t_begin)) ||
      !(h > kShortest * duration_)) {
    leapt_.reset();
    return false;
  }
  leapt_ = end;
  reach_ = kNext * h;
  return true;
}

bool LeapWatch::over_peak(StepEnd& end, Integrator& integrator) {
  constexpr double kNext = 0.125;
  const double h = end.t_end - end.t_begin;
  if (!peaks_.watches() || !(h > kShortest * duration_)) return false;
  const auto part = peaks_.look(end.t_begin, end.t_end,
                                [&](double t, State& s) { integrator.interpolate(t, s, between_.v_dot); });
  if (!part) return false;
  end.t_end = end.t_begin + *part * h;
  end.roots.clear();
  reach_ = kNext * h;
  return true;
}

bool LeapWatch::is_at_beginning(const StepEnd& end) const {
  // Of the step as it was; reach_ is an eighth of that.
  constexpr double kBeside = 1e-3;
  return end.t_end - end.t_begin <= kBeside * 8.0 * reach_;
}

void LeapWatch::widen() {
  reach_ *= 2.0;
  if (reach_ > duration_) reach_ = 0.0;
}

void LeapWatch::remember(History& history) {
  peaks_.remember(history);
  history(reach_);
  std::vector<int> harmless(harmless_.begin(), harmless_.end());
  StepEnd leapt = leapt_.value_or(StepEnd());
  history(harmless);
  history(leapt.t_begin);
  history(leapt.t_end);
  history(leapt.roots);
  if (!history.reads()) return;
  harmless_ = std::set<int>(harmless.begin(), harmless.end());
  leapt_ = leapt.roots.empty() ? std::nullopt : std::optional(leapt);
}

}  // namespace flexura::mbs
