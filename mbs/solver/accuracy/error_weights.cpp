// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/accuracy/error_weights.hpp"

#include <algorithm>
#include <cmath>

#include "mbs/solver/accuracy/scales.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {

namespace {

// Part of the run after which the first guess of the motion is made where nothing is known of its times.
constexpr double kGlance = 1e-3;
// A position far from zero is held to this many times the motion.
constexpr double kOfMotion = 100.0;
// Allowed errors of positions end here, in parts of the length (or of how far from the origin it stands): a hundredth of it, to which Newton's method
// goes down, is then fifty times the round-off of the positions that loops are closed by.  Of velocities they
// end where this error comes about within the glance: a short step turns the round-off of loops into speeds.
constexpr double kLeast = 1e-12;
// A range of speeds is resolved to this part of it.
constexpr double kOfRange = 1e-3, kNoRange = 1e300;

}  // namespace

ErrorWeights::ErrorWeights(const Equations& eq, const SolverOptions& options)
    : eq_(eq),
      tolerance_(options.tolerance),
      floor_(options.absolute_factor),
      duration_(options.end_time - options.start_time) {
  const Sizes n = eq.sizes();
  reach_p_.resize(n.n_p);
  reach_v_.resize(n.n_v);
  for (int i = 0; i < n.n_p; ++i) reach_p_(i) = 1.0 / eq.position_scale(i);
  frequency_.setZero(n.n_v);
  usual_speed_.resize(n.n_v);
  for (int i = 0; i < n.n_v; ++i) reach_v_(i) = 1.0 / eq.velocity_scale(i);
  if (options.scales && options.scales->reach_p.size() == n.n_p && options.scales->reach_v.size() == n.n_v) {
    length_ = options.scales->length;
    place_ = options.scales->farthest;
    reach_p_ = options.scales->reach_p;
    reach_v_ = options.scales->reach_v;
    if (options.scales->frequency.size() == n.n_v) frequency_ = options.scales->frequency;
  }
  // What stands still in a mechanism 500 m across that moves at 100 m/s has round-off of more than 1e-9 m/s.
  for (int i = 0; i < n.n_v; ++i) usual_speed_(i) = std::max(eq.velocity_scale(i) * reach_v_(i), length_);
  place_ = std::max(place_, length_);
  displacement_ = length_;
  speed_ = HUGE_VAL;
  narrow_ = kNoRange;
}

// At rest, disturbed by speeds of some size along all coordinates at once: a force that is hardly larger for speeds a
// thousand times as large has its range within them.
void ErrorWeights::look_for_narrow_ranges(const State& s) {
  constexpr double kFactor = 1e3, kSaturated = 10.0, kSmallest = 1e-15, kMaterial = 1e-9;
  const Sizes n = eq_.sizes();
  if (n.n_v == 0) return;
  const auto scratch = eq_.make_scratch();
  State at = s;
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(n.n_v);
  Eigen::VectorXd rest(n.n_v), r(n.n_v), c_rate(n.n_dyn), b(n.n_alg);
  const auto force = [&](double size, Eigen::VectorXd& out) {
    for (int i = 0; i < n.n_v; ++i) at.v(i) = size * (i % 2 == 0 ? 1.0 : 0.7) / reach_v_(i);
    eq_.momentum(at, still, *scratch, out, c_rate, b);
  };
  // Errors this large would matter; a range that they resolve is none.
  const double coarse = tolerance_ * floor_ / kOfRange * std::max(length_, usual_speed_.maxCoeff());
  Eigen::VectorXd large(n.n_v), small(n.n_v);
  try {
    force(0.0, rest);
    force(kFactor * coarse, large);
    large -= rest;
    const double matters = kMaterial * (rest.cwiseAbs().maxCoeff() + large.cwiseAbs().maxCoeff());
    double narrowest = kNoRange;
    for (double size = coarse; size > kSmallest * length_; size *= 0.1) {
      force(size, small);
      small -= rest;
      bool any = false;
      for (int i = 0; i < n.n_v; ++i)
        any = any || (std::abs(small(i)) > matters && std::abs(large(i)) < kSaturated * std::abs(small(i)));
      if (!any) {
        narrow_ = std::min(narrow_, narrowest);
        return;
      }
      narrowest = size;
    }
    // A jump, which has no range.
  } catch (const std::runtime_error&) {
    // Not to be evaluated at rest: nothing is known.
  }
}

void ErrorWeights::start(const State& s, const Eigen::VectorXd& v_dot) {
  look_for_narrow_ranges(s);
  if (has_start_) {
    take(s.p, s.v);
    return;
  }
  has_start_ = true;
  p_start_ = s.p;
  displacement_ = speed_ = 0.0;
  guess(s, v_dot);
}

void ErrorWeights::guess(const State& s, const Eigen::VectorXd& v_dot) {
  const auto reach = [&](const Eigen::VectorXd& x) {
    return x.size() > 0 ? x.cwiseProduct(reach_v_).lpNorm<Eigen::Infinity>() : 0.0;
  };
  double tau = kGlance * duration_;
  const double v = reach(s.v), a = reach(v_dot);
  if (!(a > 0.0) || !(tau > 0.0)) {
    displacement_ = std::min(length_, tau * v);
    speed_ = v;
    return;
  }
  // How fast the accelerations change along the motion: omega^2 = |a' - a| / |d|, as for a vibration.
  const double small = std::min(tau, 1e-6 * length_ / std::max({v, std::sqrt(a * 1e-6 * length_), 1e-300}));
  State ahead = s;
  const Eigen::VectorXd d = small * s.v + 0.5 * small * small * v_dot;
  eq_.retract(s.p, d, ahead.p);
  Eigen::VectorXd v_dot_ahead;
  try {
    AccelerationSolver(eq_).solve(ahead, v_dot_ahead);
    const double omega2 = reach(v_dot_ahead - v_dot) / std::max(reach(d), 1e-300);
    if (omega2 * tau * tau > 1.0) tau = 1.0 / std::sqrt(omega2);
  } catch (const std::runtime_error&) {
    // Beyond an edge of the model: the guess is as good as the run's length.
  }
  displacement_ = std::min(length_, tau * v + 0.5 * tau * tau * a);
  speed_ = v + tau * a;
}

void ErrorWeights::take(ConstVectorRef p, ConstVectorRef v) {
  if (!has_start_) return;
  if (displacement_ < length_)
    displacement_ = std::min(
        length_, std::max(displacement_, (p - p_start_).cwiseProduct(reach_p_).lpNorm<Eigen::Infinity>()));
  speed_ = std::max(speed_, v.cwiseProduct(reach_v_).lpNorm<Eigen::Infinity>());
}

void ErrorWeights::evaluate(ConstVectorRef p, ConstVectorRef v, ConstVectorRef c, VectorRef w,
                            double h) const {
  const double least_p = std::min(kLeast, tolerance_ * floor_) * place_,
               least_v = duration_ > 0.0 ? kLeast * place_ / (kGlance * duration_) : 0.0;
  const double most = std::min(length_, kOfMotion * displacement_);
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const double reach = reach_p_(i),
                 allowed = tolerance_ * (std::min(std::abs(p(i)) * reach, most) + floor_ * displacement_);
    // Round-off of what has gone 1e10 lengths away is larger than any part of the length.
    w(i) = reach / std::max({allowed, least_p, kLeast * std::abs(p(i)) * reach});
  }
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    const double reach = reach_v_(i);
    double allowed = tolerance_ * (std::abs(v(i)) * reach + floor_ * std::min(speed_, usual_speed_(i)));
    if (h > 0.0 && frequency_(i) > 0.0)
      allowed = std::max(allowed, tolerance_ * floor_ * displacement_ * std::min(1.0 / h, frequency_(i)));
    const double resolved = std::max(allowed, std::min(least_v, tolerance_ * floor_ * usual_speed_(i)));
    w(p.size() + i) = reach / std::min(resolved, kOfRange * narrow_ + tolerance_ * std::abs(v(i)) * reach);
  }
  w.tail(c.size()).array() = 1.0 / (tolerance_ * (c.array().abs() + floor_));
}

bool ErrorWeights::has_narrow_range() const {
  return narrow_ < kNoRange;
}

void ErrorWeights::remember(History& history) {
  history(has_start_);
  history(p_start_);
  if (history.reads() && has_start_) require_size(p_start_.size(), reach_p_.size());
  history(displacement_);
  history(speed_);
  history(narrow_);
}

}  // namespace flexura::mbs
