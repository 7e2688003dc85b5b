// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/projection.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {

Projector::Projector(const Equations& eq) : eq_(eq), n_(eq.sizes()), scratch_(eq.make_scratch()) {
  if (n_.n_lambda > 0) M_.setZero(n_.n_v, n_.n_v);
  G_.setZero(n_.n_lambda, n_.n_v);
  g_.setZero(n_.n_lambda);
  zero_.setZero(n_.n_v);
  p_.setZero(n_.n_p);
  scale_.resize(n_.n_v);
  for (int i = 0; i < n_.n_v; ++i) scale_(i) = eq.velocity_scale(i);
}

bool Projector::project(State& s) {
  // A zero move normalises quaternions.
  eq_.retract(s.p, zero_, p_);
  s.p = p_;
  if (n_.n_lambda == 0) return s.p.allFinite() && s.v.allFinite();
  eq_.mass_matrix(s.p, *scratch_, M_);
  eq_.constraint_matrix(s, s.p, *scratch_, G_);
  if (!M_.allFinite() || !G_.allFinite()) return false;
  saddle_.factor(eq_, M_, G_);
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 10; ++iteration) {
    eq_.position_constraints(s, s.p, *scratch_, g_);
    const double now = g_.cwiseProduct(saddle_.row_scale()).norm();
    if (!std::isfinite(now)) return false;
    if (now == 0.0) break;
    if (iteration > 0 && now > 0.5 * before) {
      // Either at round-off, or diverging from too far away.
      for (int k = 0; k < n_.n_lambda; ++k)
        if (std::abs(g_(k)) > 1e-11 * G_.row(k).cwiseAbs().dot(scale_) + 1e-300) return false;
      break;
    }
    before = now;
    g_ = -g_;
    saddle_.solve(zero_, g_, d_, x_);
    eq_.retract(s.p, d_, p_);
    s.p = p_;
  }
  eq_.mass_matrix(s.p, *scratch_, M_);
  eq_.constraint_matrix(s, s.p, *scratch_, G_);
  saddle_.factor(eq_, M_, G_);
  eq_.velocity_constraints(s, s.p, s.v, *scratch_, g_);
  g_ = -g_;
  saddle_.solve(zero_, g_, d_, x_);
  s.v += d_;
  return s.p.allFinite() && s.v.allFinite();
}

// What closed loops may be open by, in parts of what a typical motion changes in a row.
constexpr double kRoundOff = 1e-11;

LoopCloser::LoopCloser(const Equations& eq, const SolverOptions& options)
    : eq_(eq),
      n_(eq.sizes()),
      scratch_(eq.make_scratch()),
      weights_(eq, options),
      ranks_(eq),
      accelerations_(eq),
      enough_(std::clamp(1e-4 * options.tolerance, AccelerationSolver::at_round_off, 1e-10)) {
  if (n_.n_lambda == 0) return;
  M_.setZero(n_.n_v, n_.n_v);
  G_.setZero(n_.n_lambda, n_.n_v);
  for (Eigen::VectorXd* x : {&g_, &g_dot_, &round_off_}) x->setZero(n_.n_lambda);
  rest_.setZero(n_.n_v);
  p_.setZero(n_.n_p);
  at_factors_.p.setZero(n_.n_p);
  at_factors_.c.setZero(n_.n_dyn);
  w_.setZero(n_.n_p + n_.n_v + n_.n_dyn);
  change_.setZero(n_.n_p);
  scale_.resize(n_.n_v);
  for (int i = 0; i < n_.n_v; ++i) scale_(i) = eq.velocity_scale(i);
}

void LoopCloser::factor(const State& s) {
  has_factors_ = false;
  at_factors_.t = s.t;
  at_factors_.p = s.p;
  at_factors_.c = s.c;
  eq_.mass_matrix(s.p, *scratch_, M_);
  eq_.constraint_matrix(s, s.p, *scratch_, G_);
  saddle_.factor(eq_, M_, G_);
  for (int k = 0; k < n_.n_lambda; ++k)
    round_off_(k) = kRoundOff * G_.row(k).cwiseAbs().dot(scale_.transpose());
  has_factors_ = true;
  ranks_.note(saddle_);
}

void LoopCloser::look_at_rank(State& s, bool is_shown) {
  const double independence = ranks_.independence(s), open = kRoundOff * residuals(s).position;
  is_near_ = ranks_.is_near(independence);
  is_beside_dead_point_ = ranks_.is_beside(independence);
  if (!is_shown)
    ranks_.judge_between(independence, open);
  else if (is_near_ && is_closed_)
    close_to_the_last_digit(s);
}

// While it comes nearer: a correction that round-off asks for is as long as that over sigma.
void LoopCloser::close_to_the_last_digit(State& s) {
  factor(s);
  Residuals size = residuals(s);
  for (const bool of_position : {true, false})
    for (int iteration = 0; iteration < 5; ++iteration) {
      trial_ = s;
      if (of_position)
        correct_position(trial_);
      else
        correct_velocity(trial_);
      const Residuals now = residuals(trial_);
      const bool is_better =
          of_position ? now.position < 0.5 * size.position : now.velocity < 0.5 * size.velocity;
      if (is_better) {
        s.p = trial_.p;
        s.v = trial_.v;
        size = now;
      } else {
        residuals(s);
        break;
      }
    }
}

// In units of round-off, which grows with the speeds for those on velocity level.
LoopCloser::Residuals LoopCloser::residuals(const State& s) {
  eq_.constraints(s, s.p, s.v, *scratch_, g_, g_dot_);
  drift_ = {g_.cwiseAbs().maxCoeff(), g_dot_.cwiseAbs().maxCoeff()};
  const double speed = std::max(1.0, s.v.cwiseQuotient(scale_).lpNorm<Eigen::Infinity>());
  Residuals size;
  for (int k = 0; k < n_.n_lambda; ++k)
    if (round_off_(k) > 0.0) {
      size.position = std::max(size.position, std::abs(g_(k)) / round_off_(k));
      size.velocity = std::max(size.velocity, std::abs(g_dot_(k)) / (round_off_(k) * speed));
    }
  return size;
}

// By the residuals taken last.
void LoopCloser::correct_position(State& s) {
  g_ = -g_;
  saddle_.solve(rest_, g_, d_, x_);
  eq_.kinematic(s.p, d_, p_);  // unlike retract() it leaves the lengths of quaternions alone
  s.p += p_;
}
void LoopCloser::correct_velocity(State& s) {
  g_dot_ = -g_dot_;
  saddle_.solve(rest_, g_dot_, d_, x_);
  s.v += d_;
}

// Positions, then velocities where the positions are now: a step of fast mechanisms changes G v by more than
// its residual.  False where Newton's method does not get there.
bool LoopCloser::close_trial(const State& s, bool& is_near) {
  bool fresh = !has_factors_;
  if (fresh) factor(s);
  trial_ = s;
  Residuals size = residuals(trial_);
  for (int iteration = 0; iteration < 20 && !size.closed() && std::isfinite(size.larger()); ++iteration) {
    const bool of_position = size.position > 1.0;
    correct_position(trial_);
    // Where positions hardly move the residual of the velocities holds.
    if (!of_position) correct_velocity(trial_);
    const Residuals now = residuals(trial_);
    const double was = of_position ? size.position : size.velocity,
                 is = of_position ? now.position : now.velocity;
    if (!fresh && is > 1.0 && !(is < 0.1 * was)) {
      factor(s);
      fresh = true;
      trial_ = s;
      size = residuals(trial_);
      is_near = false;
      continue;
    }
    if (of_position) is_near = is_near || is <= std::max(1.0, 0.1 * was);
    if (is > 1.0 && !(is < 0.5 * was)) return false;
    size = now;
  }
  return size.closed();
}

LoopCloser::Drift LoopCloser::drift(const State& s) {
  if (n_.n_lambda > 0) residuals(s);
  return drift_;
}

LoopCloser::Drift LoopCloser::close(State& s, bool is_shown) {
  if (n_.n_lambda == 0) return {};
  // Newton's method takes nine tenths of g away at once: the nearest point on the constraints is this one.
  bool is_near = false, is_closed = false;
  try {
    is_closed = close_trial(s, is_near);
  } catch (const std::runtime_error&) {
    // No mass matrix there: the integrator will say so.
  }
  if (is_closed && !is_near) {
    weights_.evaluate(s.p, s.v, s.c, w_);
    change_ = trial_.p - s.p;
    is_closed = change_.cwiseProduct(w_.head(n_.n_p)).norm() <= 10.0 * std::sqrt(n_.n_p);
  }
  if (is_closed) {
    s.p = trial_.p;
    s.v = trial_.v;
  } else {
    residuals(s);
  }
  is_closed_ = is_closed;
  is_near_ = is_beside_dead_point_ = false;
  // Old factors close loops and say nothing of the rows here.
  if (is_shown || !is_closed || ranks_.is_near(ranks_.independence(saddle_))) look_at_rank(s, is_shown);
  return drift_;
}

void LoopCloser::accelerate(State& s, Eigen::VectorXd& v_dot) {
  trial_ = s;
  v_dot_0_ = v_dot;
  bool is_solved = false;
  try {
    if (!is_closed_ || is_near_ || eq_.algebraic_is_coupled()) {
      // Near a dead point multipliers grow beyond bounds: those of the state are nearer than what stands at the ends of
      // a long step, or than what old factors leave.
      accelerations_.solve(s, v_dot);
      is_solved = true;
    } else if (n_.n_lambda == 0) {
      if (n_.n_v > 0)
        accelerations_.solve(s, v_dot);
      else
        accelerations_.solve_algebraic(s);
      is_solved = true;
    } else {
      accelerations_.solve_algebraic(s);
      is_solved = has_factors_ && accelerations_.refine(saddle_, s, v_dot, enough_) <= enough_;
    }
    if (!is_solved) {
      factor(s);
      s.lambda = trial_.lambda;
      v_dot = v_dot_0_;
      // Round-off of a badly conditioned mechanism stands higher; what is far from it are forces that depend on
      // the multipliers.
      is_solved = accelerations_.refine(saddle_, s, v_dot, enough_) <=
                  std::max(enough_, 1e3 * AccelerationSolver::at_round_off);
    }
    if (!is_solved) accelerations_.solve(s, v_dot);
    is_solved = v_dot.allFinite() && s.lambda.allFinite();
  } catch (const std::runtime_error&) {
    is_solved = false;
  }
  if (is_solved) return;
  s.lambda = trial_.lambda;
  s.a = trial_.a;
  v_dot = v_dot_0_;
}

void LoopCloser::remember(History& history) {
  if (n_.n_lambda == 0) return;
  history(has_factors_);
  history(at_factors_.t);
  mbs::remember(history, at_factors_.p, n_.n_p);
  mbs::remember(history, at_factors_.c, n_.n_dyn);
  ranks_.remember(history);
  if (history.reads() && has_factors_) factor(State(at_factors_));
}

}  // namespace flexura::mbs
