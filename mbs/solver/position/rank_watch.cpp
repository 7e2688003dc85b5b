// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/rank_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {

namespace {

/// Where nothing is known of a state; finite, for histories are.
constexpr double kUnknown = 1e30;
/// What no closing takes away: positions are sums of terms of the mechanism's size.
constexpr double kLeastOpen = std::numeric_limits<double>::epsilon();

}  // namespace

RankWatch::RankWatch(const Equations& eq)
    : eq_(eq), n_(eq.sizes()), scratch_(eq.make_scratch()), accelerations_(eq) {
  if (n_.n_lambda == 0) return;
  M_.setZero(n_.n_v, n_.n_v);
  G_.setZero(n_.n_lambda, n_.n_v);
  for (Eigen::VectorXd* x : {&g_, &g_dot_, &longest_}) x->setZero(n_.n_lambda);
  rest_.setZero(n_.n_v);
  scale_.resize(n_.n_v);
  for (int i = 0; i < n_.n_v; ++i) scale_(i) = eq.velocity_scale(i);
}

// A row that vanishes (all that it joins in one line) is as bad as two that become parallel.
double RankWatch::independence(const SaddleSolver& saddle) const {
  double shortest = 1.0;
  for (int k = 0; k < n_.n_lambda; ++k) {
    const double scale = saddle.row_scale()(k);
    shortest = std::min(shortest, scale > 0.0 ? 1.0 / (scale * longest_(k)) : 0.0);
  }
  return shortest * saddle.independence();
}

void RankWatch::note(const SaddleSolver& saddle) {
  for (int k = 0; k < n_.n_lambda; ++k)
    if (const double scale = saddle.row_scale()(k); scale > 0.0)
      longest_(k) = std::max(longest_(k), 1.0 / scale);
  nearness_.largest = std::max(nearness_.largest, independence(saddle));
}

double RankWatch::independence(const State& s) {
  try {
    eq_.mass_matrix(s.p, *scratch_, M_);
    eq_.constraint_matrix(s, s.p, *scratch_, G_);
    saddle_.factor(eq_, M_, G_);
  } catch (const std::runtime_error&) {
    return std::numeric_limits<double>::quiet_NaN();  // the integrator will say so
  }
  note(saddle_);
  return independence(saddle_);
}

bool RankWatch::is_near(double independence) const {
  constexpr double kNear = 0.1, kAnyway = 0.01;
  return independence < std::max(kNear * nearness_.largest, kAnyway);
}

void RankWatch::judge_between(double independence, double open) {
  nearness_.doubt_between =
      std::max(nearness_.doubt_between, std::max(kLeastOpen, open) / (independence * independence));
}

void RankWatch::judge(const State& s, const Eigen::VectorXd& v_dot) {
  if (n_.n_lambda == 0 || n_.n_v == 0) return;
  const double sigma = independence(s);
  if (std::isnan(sigma)) return;
  sizes_ = eq_.constraint_sizes(s, s.p, *scratch_);
  eq_.constraints(s, s.p, s.v, *scratch_, g_, g_dot_);
  if (!is_near(sigma)) {
    const double open = g_.cwiseQuotient(sizes_.size.cwiseMax(1e-300)).lpNorm<Eigen::Infinity>();
    nearness_.doubt_elsewhere =
        std::max(nearness_.doubt_elsewhere, std::max(kLeastOpen, open) / (sigma * sigma));
    return;
  }
  const double doubt = change_by_what_is_open(s, v_dot);
  if (!(doubt > nearness_.doubt)) return;
  nearness_.doubt = doubt;
  nearness_.t = s.t;
  nearness_.sigma = sigma;
  nearness_.p = s.p;
}

// The signs by which rows that are open by so much move the mechanism farthest: of h^T S^-1 h, S the rows' own matrix.
void RankWatch::widest(Eigen::VectorXd& open) {
  const Eigen::VectorXd most = open;
  for (int i = 0; i < 3; ++i) {
    saddle_.solve(rest_, open, d_, x_);  // x = -S^-1 h
    for (int k = 0; k < n_.n_lambda; ++k) open(k) = x_(k) > 0.0 ? -most(k) : most(k);
  }
}

double RankWatch::change_by_what_is_open(const State& s, const Eigen::VectorXd& v_dot) {
  if (saddle_.rank() < n_.n_lambda) return kUnknown;
  const double speed = s.v.cwiseQuotient(scale_).lpNorm<Eigen::Infinity>();
  for (int k = 0; k < n_.n_lambda; ++k) {
    const double round_off = std::max(kLeastOpen * sizes_.size(k), sizes_.round_off(k));
    g_(k) = eq_.is_holonomic(k) ? std::max(std::abs(g_(k)), round_off) : 0.0;
    g_dot_(k) = std::max(std::abs(g_dot_(k)), round_off * speed);
  }
  Eigen::VectorXd open = g_, open_rate = g_dot_;
  widest(open);
  widest(open_rate);
  saddle_.solve(rest_, open, d_, x_);
  const Eigen::VectorXd move = d_;
  saddle_.solve(rest_, open_rate, d_, x_);
  const Eigen::VectorXd rate = d_;
  return std::max(change(s, v_dot, move, rest_), change(s, v_dot, -move, rest_)) +
         change(s, v_dot, rest_, rate);
}

double RankWatch::change(const State& s, const Eigen::VectorXd& v_dot, const Eigen::VectorXd& move,
                         const Eigen::VectorXd& speed) {
  trial_ = s;
  v_dot_ = v_dot;
  try {
    eq_.retract(s.p, move, trial_.p);
    eq_.mass_matrix(trial_.p, *scratch_, M_);
    eq_.constraint_matrix(trial_, trial_.p, *scratch_, G_);
    moved_.factor(eq_, M_, G_);
    // A move as long as the way to the loss of rank itself, where changes are none of first order.
    if (const double there = independence(moved_) / independence(saddle_); !(there > 0.5 && there < 2.0))
      return kUnknown;
    eq_.velocity_constraints(trial_, trial_.p, trial_.v, *scratch_, g_dot_);
    moved_.solve(rest_, -g_dot_, d_, x_);
    trial_.v += d_ + speed;
    accelerations_.solve(trial_, v_dot_);
  } catch (const std::runtime_error&) {
    return kUnknown;
  }
  const auto part = [](const Eigen::VectorXd& change, const Eigen::VectorXd& of, double least) {
    return change.lpNorm<Eigen::Infinity>() / std::max({of.lpNorm<Eigen::Infinity>(), least, 1e-300});
  };
  const Eigen::VectorXd v = s.v.cwiseQuotient(scale_);
  const double speeds = part((trial_.v - s.v).cwiseQuotient(scale_), v, 0.0);
  const double rates =
      part((v_dot_ - v_dot).cwiseQuotient(scale_), v_dot.cwiseQuotient(scale_), v.squaredNorm());
  // As moments; a reaction that is small beside the others counts by a tenth of the largest.
  const Eigen::VectorXd now = s.lambda.cwiseProduct(sizes_.size),
                        then = trial_.lambda.cwiseProduct(sizes_.size);
  const double largest = now.lpNorm<Eigen::Infinity>();
  double reactions = 0.0;
  for (int k = 0; k < n_.n_lambda; ++k)
    reactions =
        std::max(reactions, std::abs(then(k) - now(k)) / std::max({std::abs(now(k)), 0.1 * largest, 1e-300}));
  const double all = std::max({speeds, rates, reactions});
  return std::isfinite(all) ? all : kUnknown;
}

void RankWatch::remember(History& history) {
  for (double* x : {&nearness_.largest, &nearness_.doubt, &nearness_.doubt_elsewhere,
                    &nearness_.doubt_between, &nearness_.t, &nearness_.sigma})
    history(*x);
  history(nearness_.p);
  mbs::remember(history, longest_, n_.n_lambda);
  if (history.reads() && nearness_.p.size() > 0) require_size(nearness_.p.size(), n_.n_p);
}

}  // namespace flexura::mbs
