// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/switch_events.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace flexura::mbs {

namespace {

// More switchings of one switch within this part of the run are an accumulation, like the last bounces of a
// ball between impacts, or a relay whose own output takes its input back across the level.  From kManyAtOnce on a
// switch has a hysteresis.
constexpr int kMostAtOnce = 200, kManyAtOnce = 20, kMostPasses = 20;
constexpr double kAtOnce = 1e-10;
// Kinks that come so much faster than the run are left to the error control: what trembles about a kink without
// a jump would only be held up.
constexpr double kTrembling = 1e-3;

}  // namespace

SwitchEvents::SwitchEvents(const Equations& eq, Equations::Scratch& scratch, const SolverOptions& options)
    : eq_(eq),
      scratch_(scratch),
      duration_(options.end_time - options.start_time),
      values_(eq.sizes().n_root) {}

// Far from t = 0 two events cannot lie closer than the round-off of the time.
double SwitchEvents::at_once(int which, double t) const {
  return std::max((eq_.is_kink(which) ? kTrembling : kAtOnce) * duration_,
                  1e5 * std::numeric_limits<double>::epsilon() * std::abs(t));
}

int SwitchEvents::times_at_once(int which, double t, const std::vector<RootEvent>& events) const {
  const double since = t - at_once(which, t);
  int times = 0;
  for (auto event = events.rbegin(); event != events.rend() && event->t > since; ++event)
    if (event->which == which) ++times;
  return times;
}

void SwitchEvents::end_endless(int which, State& s, const std::vector<RootEvent>& events) const {
  const int times = times_at_once(which, s.t, events);
  if (times <= kMostAtOnce) return;
  if (!eq_.is_kink(which))
    throw IntegrationError(
        fmt::format("{} switches without end at t = {:.9g} s ({} times within {:.2g} s): give the "
                    "contact or the switch a hysteresis, damping or a compliant law",
                    eq_.describe_root(which), s.t, times, at_once(which, s.t)));
  s.root[static_cast<std::size_t>(which)] = 0;
}

// What takes a switch to and fro at once may be the round-off of its own function (teeth that graze each other at hardly any
// speed): from then on it counts only where it is clearly below 0. A relay whose output takes its input back across the
// level goes on as before, since it falls below that, too.
//
// Where nothing jumps the same dynamics rule on both sides, and nothing but the error of the steps takes the switch to and
// fro: a stiff damper on hardly any mass has forces that these do not know to round-off.  It then gets twice as much
// every time, until it stays.
void SwitchEvents::give_hysteresis(const std::vector<int>& roots, State& s,
                                   const std::vector<RootEvent>& events) {
  constexpr double kClearly = 10.0, kMore = 2.0;  // of what it was below at a switching; of what it had
  const auto is_at_once = [&](int which) {
    return !eq_.is_kink(which) && times_at_once(which, s.t, events) > kManyAtOnce;
  };
  if (std::ranges::none_of(roots, is_at_once)) return;
  eq_.roots(s, scratch_, values_);
  if (s.hysteresis.size() == 0) s.hysteresis.setZero(values_.size());
  for (const int which : roots)
    if (is_at_once(which))
      s.hysteresis(which) = std::max(s.hysteresis(which) * (eq_.jumps_at(which) ? 1.0 : kMore),
                                     kClearly * std::abs(values_(which)));
}

void SwitchEvents::change(const std::vector<int>& roots, State& s, std::vector<RootEvent>& events) {
  give_hysteresis(roots, s, events);
  for (const int which : roots) {
    const bool jumped = eq_.on_root(which, s, scratch_);
    events.push_back({s.t, which, jumped});
  }
  for (const int which : roots) end_endless(which, s, events);
}

void SwitchEvents::take(const std::vector<int>& roots, State& s, std::vector<RootEvent>& events) {
  change(roots, s, events);
  // What they changed may be what conditions in formulas look at.
  std::vector<int> changed = roots, others;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    eq_.roots(s, scratch_, values_);
    others.clear();
    for (int k = 0; k < values_.size(); ++k)
      if (eq_.is_condition(k) && values_(k) < 0.0 && std::ranges::find(changed, k) == changed.end())
        others.push_back(k);
    if (others.empty()) break;
    change(others, s, events);
    changed = others;
  }
}

}  // namespace flexura::mbs
