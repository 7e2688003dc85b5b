// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/switches.hpp"

#include <cmath>
#include <limits>

namespace flexura::mbs {

SwitchFinder::SwitchFinder(const Equations& eq)
    : eq_(eq), n_root_(eq.sizes().n_root), scratch_(eq.make_scratch()) {
  low_.setZero(n_root_);
  high_.setZero(n_root_);
  middle_.setZero(n_root_);
}

void SwitchFinder::evaluate(const State& s, Eigen::VectorXd& values) {
  eq_.roots(s, *scratch_, values);
}

void SwitchFinder::start(const State& s) {
  if (n_root_ > 0) evaluate(s, low_);
}

bool SwitchFinder::search(double t_begin, double& t_end, const std::function<const State&(double)>& state_at,
                          std::vector<int>& which) {
  which.clear();
  if (n_root_ == 0) return false;
  for (int k = 0; k < n_root_; ++k)
    if (low_(k) == 0.0) {
      evaluate(state_at(t_begin + 1e-3 * (t_end - t_begin)), middle_);
      for (int j = 0; j < n_root_; ++j)
        if (low_(j) == 0.0) low_(j) = middle_(j);
      break;
    }
  auto changes = [&](const Eigen::VectorXd& values, int k) {
    return low_(k) != 0.0 && low_(k) * values(k) <= 0.0;
  };
  auto any_change = [&](const Eigen::VectorXd& values) {
    for (int k = 0; k < n_root_; ++k)
      if (changes(values, k)) return true;
    return false;
  };
  evaluate(state_at(t_end), high_);
  if (!any_change(high_)) {
    low_ = high_;
    return false;
  }
  double a = t_begin, b = t_end, weight = 1.0;
  int last_side = 0;
  const double resolution =
      20.0 * std::numeric_limits<double>::epsilon() * (std::abs(t_end) + (t_end - t_begin));
  for (int iteration = 0; iteration < 200 && b - a > resolution; ++iteration) {
    // The function whose secant crosses zero first leads.
    double t = b;
    for (int k = 0; k < n_root_; ++k)
      if (changes(high_, k)) {
        const double fraction = high_(k) == low_(k) ? 0.5 : weight * low_(k) / (weight * low_(k) - high_(k));
        t = std::min(t, a + fraction * (b - a));
      }
    if (iteration > 60) t = 0.5 * (a + b);
    t = std::min(std::max(t, a + 0.5 * resolution), b - 0.5 * resolution);
    evaluate(state_at(t), middle_);
    if (any_change(middle_)) {
      b = t;
      high_ = middle_;
      weight = last_side == 1 ? weight * 2.0 : 1.0;
      last_side = 1;
    } else {
      a = t;
      low_ = middle_;
      weight = last_side == -1 ? weight * 0.5 : 1.0;
      last_side = -1;
    }
  }
  t_end = b;
  for (int k = 0; k < n_root_; ++k)
    if (changes(high_, k)) which.push_back(k);
  low_ = high_;
  return true;
}

}  // namespace flexura::mbs
