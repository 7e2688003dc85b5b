// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/radau/radau_newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace flexura::mbs {

namespace {

// Newton's method may contract this slowly with the derivatives of an earlier step.  Of a turning engine with
// 20 modes two thirds of them are saved for 6 % more iterations; at 0.2 the iterations cost more than that.
constexpr double kSlow = 0.05;
// Corrections of this part of the error allowed may be left where round-off makes them.
constexpr double kEndOfDescent = 0.1;

// Newton's method has come down to the round-off of the residuals, which masses of 1e9 and 1 kg on one
// another, or constraints near a position where they lose rank, lift above its goal: what it corrects is a
// small part of the error allowed, and it no longer contracts as it did before.  Shorter steps would meet
// the same round-off.
bool reached_round_off(double size, double before, double ratio_before) {
  const double ratio = size / before;
  if (size > kEndOfDescent) return false;
  return ratio_before > 0.0 ? ratio > std::max(0.3, 5.0 * ratio_before)
                            : before <= kEndOfDescent && ratio > 0.9;
}

}  // namespace

RadauNewton::RadauNewton(const RadauTableau& tableau, StabilisedIndex2& form, double tolerance)
    : k_(tableau), form_(form), tolerance_(tolerance), stage_(form.size()), rate_(form.size()) {
  for (Eigen::VectorXd& R : R_) R.setZero(form.size());
}

void RadauNewton::start() {
  convergence_ = 1.0;
  theta_ = 0.0;
}

bool RadauNewton::is_slow() const {
  return theta_ > kSlow;
}

RadauNewton::Result RadauNewton::iterate(const Step& step, int most, int trusted, const Solve& solve,
                                         Stages& Z) {
  // Steps follow an estimate of order 3, so the method's own error goes with the tolerance to the power 3/2: what is left of the
  // stages has to fall faster than that, or the method is of order 3, too (RADAU5's root of the tolerance leaves 4).  Hardly
  // more work at 1e-5 than with a hundredth, a third more at 1e-9, for a tenth and less of the error.
  const double goal = std::max(10.0 * std::numeric_limits<double>::epsilon() / tolerance_,
                               std::min(1e-2, 9.0 * std::pow(tolerance_, 0.75)));
  convergence_ = std::pow(std::max(convergence_, std::numeric_limits<double>::epsilon()), 0.8);
  double before = 0.0, ratio_before = 0.0;
  Result result{Outcome::slow, 0.5, 0, {}};
  const auto end = [&](Outcome outcome) {
    result.outcome = outcome;
    return result;
  };
  for (int k = 1; k <= most; ++k) {
    for (int i = 0; i < 3; ++i) {
      stage_ = step.y + Z[i];
      rate_ = (k_.B(i, 0) * Z[0] + k_.B(i, 1) * Z[1] + k_.B(i, 2) * Z[2]) / step.h;
      if (!form_.residual(std::min(step.t + k_.c[i] * step.h, step.t_stop), stage_, rate_, R_[i])) {
        result.trouble = form_.non_finite();
        return end(Outcome::diverged);
      }
    }
    solve(R_);
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += R_[i].cwiseAbs2().dot(step.weights2);
    const double size = std::sqrt(sum / (3.0 * step.n_norm));
    if (!std::isfinite(size)) return end(Outcome::diverged);
    result.iterations = k;
    if (k > 1 && reached_round_off(size, before, ratio_before)) {
      convergence_ = 1.0;
      theta_ = std::min(theta_, kSlow);
      return end(Outcome::converged);
    }
    if (k > 1 && k < most) {
      const double ratio = size / before;
      theta_ = k == 2 ? ratio : std::sqrt(ratio * ratio_before);
      ratio_before = ratio;
      if (theta_ >= 0.99 && (k > trusted || ratio > 10.0)) return end(Outcome::diverged);
      convergence_ = theta_ < 0.99 ? theta_ / (1.0 - theta_) : 100.0;
      const double at_end =
          convergence_ * size * std::pow(theta_, most - 1 - k) / goal;  // after the last iteration
      if (at_end >= 1.0 && k > trusted) {
        result.shorter = 0.8 * std::pow(std::clamp(at_end, 1e-4, 20.0), -1.0 / (3 + most - k));
        return end(Outcome::slow);
      }
    }
    before = std::max(size, std::numeric_limits<double>::epsilon());
    for (int i = 0; i < 3; ++i) Z[i] += R_[i];
    // Where stiffness may end within the step one small correction proves nothing.
    if (convergence_ * size <= goal && (k > 1 || !step.is_narrow)) return end(Outcome::converged);
  }
  return end(Outcome::slow);
}

void RadauNewton::remember(History& history) {
  for (double* x : {&theta_, &convergence_}) history(*x);
}

}  // namespace flexura::mbs
