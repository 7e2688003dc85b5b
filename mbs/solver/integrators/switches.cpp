// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/switches.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {

SwitchFinder::SwitchFinder(const Equations& eq)
    : eq_(eq), n_root_(eq.sizes().n_root), scratch_(eq.make_scratch()) {
  low_.setZero(n_root_);
  high_.setZero(n_root_);
  middle_.setZero(n_root_);
  for (int k = 0; k < n_root_; ++k) (eq.is_condition(k) ? conditions_ : others_).push_back(k);
  before_.setZero(n_root_);
  for (Eigen::VectorXd& values : between_) values.setZero(n_root_);
}

// Where within the step a condition was crossed and crossed back, with the values there in high_; t_end where
// none was.
double SwitchFinder::first_dip(double t_begin, double t_end, const Evaluate& evaluate) {
  if (conditions_.empty()) return t_end;
  const double quarter = 0.25 * (t_end - t_begin);
  const auto is_below = [&](const Eigen::VectorXd& values) {
    return std::ranges::any_of(conditions_, [&](int k) { return values(k) < 0.0; });
  };
  for (int i = 0; i < 3; ++i) {
    evaluate(t_begin + (i + 1) * quarter, between_[i]);
    if (!is_below(between_[i])) continue;
    high_ = between_[i];
    return t_begin + (i + 1) * quarter;
  }
  const Eigen::VectorXd* at[] = {&low_, &between_[0], &between_[1], &between_[2], &high_};
  for (int i = 1; i < 4; ++i)
    for (const int k : conditions_) {
      const double a = (*at[i - 1])(k), b = (*at[i])(k), c = (*at[i + 1])(k);
      const double bend = a - 2.0 * b + c, x = 0.5 * (a - c) / bend;  // in quarters
      if (!(bend > 0.0) || std::abs(x) > 0.5 || b - 0.125 * (a - c) * (a - c) / bend > 0.0) continue;
      const double t = t_begin + (i + x) * quarter;
      evaluate(t, middle_);
      if (!is_below(middle_)) continue;
      high_ = middle_;
      return t;
    }
  return t_end;
}

// Faster than it came in the last step by no more than this factor.
bool SwitchFinder::may_dip(int k, double h) const {
  constexpr double kFaster = 4.0;
  if (!(low_(k) > 0.0)) return false;
  if (!(h_before_ > 0.0)) return true;
  const double rate = (low_(k) - before_(k)) / h_before_;
  return rate < 0.0 && -kFaster * rate * h > low_(k);
}

// The least value between a and b, or the first below 0, left in middle_; returns where.
double SwitchFinder::bottom(int k, double a, double b, double steepest, const Evaluate& evaluate) {
  constexpr double kGolden = 0.6180339887498949, kFinest = 1e-10;
  const double finest =
      std::max(kFinest * (b - a), 20.0 * std::numeric_limits<double>::epsilon() * std::abs(b));
  const auto value = [&](double t) {
    evaluate(t, middle_);
    return middle_(k);
  };
  double x = b - kGolden * (b - a), y = a + kGolden * (b - a), f_x = value(x);
  if (f_x < 0.0) return x;
  double f_y = value(y);
  while (f_y >= 0.0 && b - a > finest && std::min(f_x, f_y) < steepest * (b - a)) {
    if (f_x < f_y) {
      b = y;
      y = x;
      f_y = f_x;
      x = b - kGolden * (b - a);
      f_x = value(x);
      if (f_x < 0.0) return x;
    } else {
      a = x;
      x = y;
      f_x = f_y;
      y = a + kGolden * (b - a);
      f_y = value(y);
    }
  }
  return y;
}

// The same of other switches that come towards 0: t_end where none reaches it.
double SwitchFinder::dip_of_approach(double t_begin, double t_end, const Evaluate& evaluate) {
  const double h = t_end - t_begin;
  std::vector<int> close;
  for (const int k : others_)
    if (may_dip(k, h)) close.push_back(k);
  if (close.empty()) return t_end;
  // Beside both ends, too: which way it goes there.
  constexpr std::array kPlaces = {0.0, 1e-3, 0.25, 0.5, 0.75, 1.0 - 1e-3, 1.0};
  std::array<Eigen::VectorXd, kPlaces.size()> at;
  for (std::size_t i = 0; i < at.size(); ++i) {
    at[i] = low_;
    if (i + 1 == at.size())
      at[i] = high_;
    else if (i > 0)
      evaluate(t_begin + kPlaces[i] * h, at[i]);
  }
  double first = t_end;
  for (const int k : close)
    for (std::size_t i = 1; i + 1 < at.size(); ++i) {
      const double t = t_begin + kPlaces[i] * h;
      if (t >= first) break;
      if (at[i](k) < 0.0) {
        first = t;
        high_ = at[i];
        break;
      }
      if (at[i](k) > at[i - 1](k) || at[i](k) > at[i + 1](k)) continue;
      const double left = (at[i - 1](k) - at[i](k)) / (kPlaces[i] - kPlaces[i - 1]),
                   right = (at[i + 1](k) - at[i](k)) / (kPlaces[i + 1] - kPlaces[i]);
      // A distance is convex where it is least: no bottom lies below what falls on at the steepest slope around.
      const double steepest = 4.0 * std::max(left, right) / h;
      const double dip =
          bottom(k, t_begin + kPlaces[i - 1] * h, t_begin + kPlaces[i + 1] * h, steepest, evaluate);
      if (!(middle_(k) < 0.0) || dip >= first) continue;
      first = dip;
      high_ = middle_;
    }
  return first;
}

void SwitchFinder::start(const State& s) {
  found_ = s;
  h_before_ = 0.0;
  if (n_root_ > 0) eq_.roots(s, *scratch_, low_);
}

void SwitchFinder::search(StepEnd& end, const StateAt& state_at) {
  end.t_tried = end.t_end;
  if (n_root_ == 0) return;
  const double t_begin = end.t_begin;
  double t_end = end.t_end;
  const auto evaluate = [&](double t, Eigen::VectorXd& values) {
    state_at(t, found_);
    eq_.roots(found_, *scratch_, values);
  };
  evaluate(t_end, high_);
  if (!any_negative(high_)) {
    double dip = first_dip(t_begin, t_end, evaluate);
    if (dip == t_end) dip = dip_of_approach(t_begin, t_end, evaluate);
    if (dip == t_end) {
      before_ = low_;
      h_before_ = t_end - t_begin;
      low_.swap(high_);
      return;
    }
    t_end = dip;
  }
  double a = t_begin, b = t_end;
  // What stands at 0 to round-off, and for a restart that is either side of it, shows a little later whether
  // it set out the right way.
  const double later = t_begin + 1e-3 * (t_end - t_begin);
  for (int k = 0; k < n_root_; ++k)
    if (high_(k) < 0.0 && !(low_(k) > 0.0)) {
      evaluate(later, middle_);
      if (any_negative(middle_)) {
        b = later;
        high_.swap(middle_);
      } else {
        a = later;
        low_.swap(middle_);
      }
      break;
    }
  double weight = 1.0;
  int last_side = 0;
  const double resolution =
      20.0 * std::numeric_limits<double>::epsilon() * (std::abs(t_end) + (t_end - t_begin));
  for (int iteration = 0; iteration < 200 && b - a > resolution; ++iteration) {
    // The function whose secant crosses zero first leads; halves where there is no secant.
    double t = b;
    for (int k = 0; k < n_root_; ++k)
      if (high_(k) < 0.0) {
        const double fraction = low_(k) > 0.0 ? weight * low_(k) / (weight * low_(k) - high_(k)) : 0.5;
        t = std::min(t, a + fraction * (b - a));
      }
    if (iteration > 60) t = 0.5 * (a + b);
    t = std::min(std::max(t, a + 0.5 * resolution), b - 0.5 * resolution);
    evaluate(t, middle_);
    if (any_negative(middle_)) {
      b = t;
      high_.swap(middle_);
      weight = last_side == 1 ? weight * 2.0 : 1.0;
      last_side = 1;
    } else {
      a = t;
      low_.swap(middle_);
      weight = last_side == -1 ? weight * 0.5 : 1.0;
      last_side = -1;
    }
  }
  end.t_end = b;
  for (int k = 0; k < n_root_; ++k)
    if (high_(k) < 0.0) end.roots.push_back(k);
}

void SwitchFinder::remember(History& history, const State& s) {
  if (history.reads()) found_ = s;
  mbs::remember(history, low_, n_root_);
  mbs::remember(history, before_, n_root_);
  history(h_before_);
}

}  // namespace flexura::mbs
