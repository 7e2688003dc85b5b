// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/generalised_alpha.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/solver/accuracy/error_weights.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/finite.hpp"
#include "mbs/solver/algebra/remembered.hpp"
#include "mbs/solver/integrators/alpha_matrix.hpp"
#include "mbs/solver/integrators/switches.hpp"

namespace flexura::mbs {

namespace {

using Eigen::VectorXd;

class GeneralisedAlpha final : public Integrator {
 public:
  GeneralisedAlpha(const Equations& eq, const SolverOptions& options)
      : eq_(eq),
        n_(eq.sizes()),
        options_(options),
        k_(options.rho_inf),
        scratch_(eq.make_scratch()),
        accelerations_(eq),
        matrix_(eq, k_),
        weights_(eq, options),
        switches_(eq) {
    const int n_z = n_.n_v + n_.n_dyn + n_.n_alg, n_x = n_z + n_.n_lambda;
    F_.setZero(n_x);
    x_.setZero(n_x);
    d_.setZero(n_.n_v);
    unused_.setZero(n_.n_v);
    g_dot_.setZero(n_.n_lambda);
    g_.setZero(n_.n_lambda);
    mu_.setZero(n_.n_lambda);
    w_.setZero(n_.n_p + n_.n_v + n_.n_dyn);
    error_ = w_;
    round_off_.resize(n_.n_v);
    for (int i = 0; i < n_.n_v; ++i) round_off_(i) = 1e-14 * eq.velocity_scale(i);
    for (int k = 0; k < n_.n_lambda; ++k) holonomic_.push_back(eq.is_holonomic(k));
  }

  void start(const State& s, const VectorXd& v_dot) override;
  StepEnd step(double t_stop) override;
  void interpolate(double t, State& s, VectorXd& v_dot) override;
  StepCounts counts() const override {
    StepCounts c = counts_;
    c.jacobians = matrix_.factored();
    c.evaluations += matrix_.evaluations();
    return c;
  }
  void remember(History& history) override;

 private:
  // A point of the trajectory: the state, v', c' and the method's own accelerations and rates.
  struct Point {
    State s;
    VectorXd v_dot, c_dot, w, w_c;
  };
  enum class Outcome { converged, diverged };

  void place(double h);              // p, v, c of next_ from its v', c'
  void residual();                   // F_ at next_
  Outcome newton(double h);          // next_ by Newton's method from its prediction
  double correction_size(double h);  // of x_ in units of the error allowed
  double local_error(double h);      // in units of the error allowed
  void state_at(double t, State& s);
  int worst_state() const;
  std::string name_of(int i) const {
    return i < n_.n_p            ? eq_.name_of_position(i)
           : i < n_.n_p + n_.n_v ? eq_.name_of_velocity(i - n_.n_p)
                                 : eq_.name_of_dynamic(i - n_.n_p - n_.n_v);
  }

  const Equations& eq_;
  Sizes n_;
  SolverOptions options_;
  AlphaCoefficients k_;
  std::unique_ptr<Equations::Scratch> scratch_;
  AccelerationSolver accelerations_;
  AlphaMatrix matrix_;
  ErrorWeights weights_;
  SwitchFinder switches_;
  Point now_, next_, before_;  // before_: the beginning of the last step, for its polynomial
  VectorXd v_dot_older_;       // v' one step before now_
  VectorXd F_, x_, d_, d_before_, g_, g_dot_, mu_, unused_, w_, error_, round_off_;
  std::vector<bool> holonomic_;
  StepCounts counts_;
  std::string trouble_;
  double h_ = 0.0, h_w_ = 0.0, h_older_ = 0.0, h_done_ = 0.0;
  bool started_ = false;
};

void GeneralisedAlpha::start(const State& s, const VectorXd& v_dot) {
  if (started_) ++counts_.restarts;
  started_ = true;
  now_.s = s;
  now_.v_dot = v_dot;
  weights_.start(s, v_dot);
  State ahead = s;
  VectorXd v_dot_ahead;
  accelerations_.solve(ahead, v_dot_ahead);
  now_.c_dot = accelerations_.c_rate();
  now_.s.lambda = ahead.lambda;
  now_.s.a = ahead.a;
  // The jerk by a short step along the motion gives w_0 and a first step whose error is small.
  const double duration = options_.end_time - options_.start_time;
  const double speed = std::max(1e-300, s.v.lpNorm<Eigen::Infinity>());
  const double tau = std::min({1e-6 * duration, 1e-4 / speed, 0.5 * (horizon_ - s.t)});
  d_ = tau * s.v + 0.5 * tau * tau * v_dot;
  eq_.retract(s.p, d_, ahead.p);
  ahead.v += tau * v_dot;
  ahead.c += tau * now_.c_dot;
  ahead.t += tau;
  VectorXd jerk = VectorXd::Zero(n_.n_v), c_jerk = VectorXd::Zero(n_.n_dyn);
  if (tau > 0.0) try {
      accelerations_.solve(ahead, v_dot_ahead);
      jerk = (v_dot_ahead - v_dot) / tau;
      c_jerk = (accelerations_.c_rate() - now_.c_dot) / tau;
    } catch (const std::runtime_error&) {
      // Beyond an edge of the model: start without it, at order 1 for one step.
    }
  if (options_.fixed_step > 0.0) {
    h_ = options_.fixed_step;
  } else if (options_.first_step > 0.0) {
    h_ = options_.first_step;
  } else {
    weights_.evaluate(s.p, s.v, s.c, w_);
    const double rate =
        std::max(jerk.cwiseProduct(w_.segment(n_.n_p, n_.n_v)).lpNorm<Eigen::Infinity>(),
                 v_dot.cwiseProduct(w_.segment(n_.n_p, n_.n_v)).lpNorm<Eigen::Infinity>() / duration);
    h_ = std::min(1e-3 * duration, rate > 0.0 ? 0.1 * std::cbrt(1.0 / rate) : 1e-3 * duration);
  }
  // A step longer than the time in which the accelerations change, omega^2 = |a' - a| / |d|, has no use for
  // their rate of change: carried on for that long it would be larger than they ever get.
  const auto size = [&](const VectorXd& x) { return x.cwiseProduct(w_.segment(n_.n_p, n_.n_v)).norm(); };
  weights_.evaluate(s.p, s.v, s.c, w_);
  if (h_ * h_ * tau * size(jerk) > size(d_)) {
    jerk.setZero();
    c_jerk.setZero();
  }
  h_w_ = h_;
  now_.w = v_dot + k_.delta * h_ * jerk;
  now_.w_c = now_.c_dot + k_.delta * h_ * c_jerk;
  v_dot_older_ = v_dot - h_ * jerk;
  h_older_ = h_;
  matrix_.forget();
  next_ = before_ = now_;
  h_done_ = 0.0;
  switches_.start(now_.s);
}

void GeneralisedAlpha::place(double h) {
  next_.w =
      ((1.0 - k_.alpha_f) * next_.v_dot + k_.alpha_f * now_.v_dot - k_.alpha_m * now_.w) / (1.0 - k_.alpha_m);
  next_.w_c = ((1.0 - k_.alpha_f) * next_.c_dot + k_.alpha_f * now_.c_dot - k_.alpha_m * now_.w_c) /
              (1.0 - k_.alpha_m);
  d_ = h * now_.s.v + h * h * ((0.5 - k_.beta) * now_.w + k_.beta * next_.w);
  eq_.retract(now_.s.p, d_, next_.s.p);
  next_.s.v = now_.s.v + h * ((1.0 - k_.gamma) * now_.w + k_.gamma * next_.w);
  next_.s.c = now_.s.c + h * ((1.0 - k_.gamma) * now_.w_c + k_.gamma * next_.w_c);
}

void GeneralisedAlpha::residual() {
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_z = n_v + n_c + n_a;
  eq_.residuals(next_.s, next_.v_dot, mu_, *scratch_, F_.head(n_v), F_.segment(n_v, n_c),
                F_.segment(n_v + n_c, n_a), g_dot_, g_, unused_);
  ++counts_.evaluations;
  if (!F_.head(n_z).allFinite()) {
    trouble_ =
        describe_non_finite(eq_, next_.s.t, F_.head(n_v), F_.segment(n_v, n_c), F_.segment(n_v + n_c, n_a));
    throw NonFiniteError(trouble_);
  }
  F_.segment(n_v, n_c) = next_.c_dot - F_.segment(n_v, n_c);
  for (int k = 0; k < n_.n_lambda; ++k) F_(n_z + k) = holonomic_[k] ? g_(k) : g_dot_(k);
}

double GeneralisedAlpha::correction_size(double h) {
  // What this correction of v' and c' does to p, v and c.
  const double by_v = k_.by_v(h), by_d = k_.by_d(h);
  eq_.kinematic(next_.s.p, x_.head(n_.n_v), error_.head(n_.n_p));
  error_.head(n_.n_p) *= by_d;
  error_.segment(n_.n_p, n_.n_v) = by_v * x_.head(n_.n_v);
  error_.tail(n_.n_dyn) = by_v * x_.segment(n_.n_v, n_.n_dyn);
  // Positions carry round-off, and the constraints turn it into velocities 1 / h times as large: below that
  // nothing can be corrected.
  for (int i = 0; i < n_.n_v; ++i) {
    double& e = error_(n_.n_p + i);
    e = std::copysign(std::max(0.0, std::abs(e) - round_off_(i) / h), e);
  }
  return error_.cwiseProduct(w_).norm() / std::sqrt(static_cast<double>(std::max<long>(1, w_.size())));
}

GeneralisedAlpha::Outcome GeneralisedAlpha::newton(double h) {
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda, n_z = n_v + n_c + n_a;
  const double by_v = k_.by_v(h), by_d = k_.by_d(h);
  bool fresh = false;
  if (matrix_.h() == 0.0 || std::abs(h / matrix_.h() - 1.0) > 0.3) {
    matrix_.factor(h, next_.s, next_.v_dot);
    fresh = true;
  }
  for (;;) {
    double before = 0.0;
    bool converged = false;
    for (int iteration = 0; iteration < 10; ++iteration) {
      residual();
      // g moves with d, by_d times v'.
      for (int k = 0; k < n_l; ++k) F_(n_z + k) /= holonomic_[k] ? by_d : by_v;
      F_ = -F_;
      matrix_.solve(F_, x_);
      if (!x_.allFinite()) break;
      next_.v_dot += x_.head(n_v);
      next_.c_dot += x_.segment(n_v, n_c);
      next_.s.a += x_.segment(n_v + n_c, n_a);
      next_.s.lambda += x_.tail(n_l);
      place(h);
      const double size = correction_size(h);
      // Round-off of g, which h^2 amplifies, can end the descent above the goal: a tenth of the error allowed
      // is good enough then.
      if (iteration > 0 && size > 0.5 * before) {
        converged = size < 0.1;
        break;
      }
      const double rate = iteration > 0 ? size / before : 0.3;
      // A hundredth of the error allowed, as for IDA; at least two, so that constraints close.
      if (size == 0.0 || (iteration > 0 && size * std::min(rate, 0.9) / (1.0 - std::min(rate, 0.9)) < 1e-2)) {
        converged = true;
        break;
      }
      before = size;
    }
    if (converged) return Outcome::converged;
    if (fresh) return Outcome::diverged;
    matrix_.factor(h, next_.s, next_.v_dot);
    fresh = true;
  }
}

double GeneralisedAlpha::local_error(double h) {
  // Of positions also what constraints prescribe: they close loops however long the step, but a step that
  // does not resolve the motion finds wrong accelerations and forces, and Newton's method fails with every
  // longer one.
  unused_ = k_.error_p * h * h * (next_.w - now_.w);
  eq_.kinematic(next_.s.p, unused_, error_.head(n_.n_p));
  unused_ = (next_.v_dot - now_.v_dot) / h - (now_.v_dot - v_dot_older_) / h_older_;
  unused_ *= k_.error_v * h * h * h * 2.0 / (h + h_older_);
  matrix_.filter(unused_);
  error_.segment(n_.n_p, n_.n_v) = unused_;
  // Of first-order states: as of velocities, with the change of their rates for the second difference.
  error_.tail(n_.n_dyn) = std::abs(k_.error_v) * h * (next_.w_c - now_.w_c);
  weights_.evaluate(next_.s.p, next_.s.v, next_.s.c, w_);
  error_.array() *= w_.array();
  const double size = error_.norm() / std::sqrt(static_cast<double>(std::max<long>(1, w_.size())));
  return std::isfinite(size) ? size : std::numeric_limits<double>::infinity();
}

int GeneralisedAlpha::worst_state() const {
  int i = 0;
  if (error_.size() > 0) error_.cwiseAbs().maxCoeff(&i);
  return i;
}

StepEnd GeneralisedAlpha::step(double t_stop) {
  const double duration = options_.end_time - options_.start_time;
  const double h_max = options_.longest_step();
  const double h_min = options_.min_step > 0.0 ? options_.min_step : 1e-12 * duration;
  const bool fixed = options_.fixed_step > 0.0;
  weights_.evaluate(now_.s.p, now_.s.v, now_.s.c, w_);
  double h, size = 0.0;
  bool shortened = false;
  std::string ahead;  // why the model could not be evaluated in a step that was tried
  for (;;) {
    const double left = t_stop - now_.s.t;
    h = std::min({h_, h_max, left});
    shortened = h == left && left < h_;
    if (left - h < 1e-3 * h) h = left;
    now_.w = now_.v_dot + (h / h_w_) * (now_.w - now_.v_dot);
    now_.w_c = now_.c_dot + (h / h_w_) * (now_.w_c - now_.c_dot);
    h_w_ = h;
    next_ = now_;
    next_.s.t = std::min(now_.s.t + h, t_stop);
    next_.v_dot += (h / h_older_) * (now_.v_dot - v_dot_older_);
    place(h);
    Outcome outcome = Outcome::diverged;
    trouble_.clear();
    try {
      outcome = newton(h);
      if (outcome == Outcome::converged && !fixed) size = local_error(h);
    } catch (const std::runtime_error& e) {
      trouble_ = e.what();
      // What a longer step met lies ahead of all shorter ones.
      if (dynamic_cast<const NonFiniteError*>(&e) == nullptr) ahead = trouble_;
    }
    if (outcome == Outcome::converged && (fixed || size <= 1.0)) break;
    if (outcome == Outcome::converged)
      ++counts_.error_failures;
    else
      ++counts_.newton_failures;
    matrix_.forget();
    if (h <= h_min || fixed) {
      if (!ahead.empty() || !trouble_.empty()) throw IntegrationError(ahead.empty() ? trouble_ : ahead);
      throw IntegrationError(
          fmt::format("{} at t = {:.9g} s with a step of {:.3g} s; the state in trouble is \"{}\": a force "
                      "jumps there, give it "
                      "a switch or smooth it{}",
                      outcome == Outcome::converged ? "the error test keeps failing"
                                                    : "Newton's method does not converge",
                      now_.s.t, h, name_of(worst_state()), fixed ? ", or use a smaller fixed_step" : ""));
    }
    h_ = outcome == Outcome::converged ? h * std::clamp(0.9 * std::cbrt(1.0 / size), 0.1, 0.9) : 0.25 * h;
  }
  ++counts_.steps;
  if (!fixed) {
    const double growth = std::clamp(0.9 * std::cbrt(1.0 / std::max(size, 1e-6)), 0.2, 2.0);
    // Small changes do not pay for a new matrix; a last step cut short says nothing against the one before.
    if (shortened)
      h_ = std::max(h_, h * growth);
    else if (growth < 1.0 || growth > 1.2)
      h_ = h * growth;
    else
      h_ = h;
  }
  StepEnd end;
  end.t_begin = now_.s.t;
  end.t_end = now_.s.t + h >= t_stop ? t_stop : now_.s.t + h;
  next_.s.t = end.t_end;
  v_dot_older_ = now_.v_dot;
  h_older_ = h;
  std::swap(before_, now_);
  std::swap(now_, next_);
  d_before_ = d_;
  h_done_ = h;
  weights_.take(now_.s.p, now_.s.v);
  switches_.search(end, [&](double t, State& s) { state_at(t, s); });
  return end;
}

void GeneralisedAlpha::state_at(double t, State& s) {
  if (h_done_ == 0.0 || t >= now_.s.t) {
    s = now_.s;
    return;
  }
  // Cubic through both ends' values and rates.
  const double h = h_done_, x = (t - before_.s.t) / h, y = 1.0 - x;
  const double to_1 = x * x * (3.0 - 2.0 * x), rate_0 = h * x * y * y, rate_1 = -h * x * x * y;
  s.t = t;
  s.root = now_.s.root;
  s.u = now_.s.u;
  unused_ = to_1 * d_before_ + rate_0 * before_.s.v + rate_1 * now_.s.v;
  s.p.resize(n_.n_p);
  eq_.retract(before_.s.p, unused_, s.p);
  s.v = (1.0 - to_1) * before_.s.v + to_1 * now_.s.v + rate_0 * before_.v_dot + rate_1 * now_.v_dot;
  s.c = (1.0 - to_1) * before_.s.c + to_1 * now_.s.c + rate_0 * before_.c_dot + rate_1 * now_.c_dot;
  s.a = y * before_.s.a + x * now_.s.a;
  s.lambda = y * before_.s.lambda + x * now_.s.lambda;
}

void GeneralisedAlpha::interpolate(double t, State& s, VectorXd& v_dot) {
  state_at(t, s);
  const double x = h_done_ == 0.0 || t >= now_.s.t ? 1.0 : (t - before_.s.t) / h_done_;
  v_dot = (1.0 - x) * before_.v_dot + x * now_.v_dot;
}

void GeneralisedAlpha::remember(History& history) {
  for (Point* x : {&now_, &before_}) {
    mbs::remember(history, x->s, n_);
    for (VectorXd* y : {&x->v_dot, &x->w}) mbs::remember(history, *y, n_.n_v);
    for (VectorXd* y : {&x->c_dot, &x->w_c}) mbs::remember(history, *y, n_.n_dyn);
  }
  mbs::remember(history, v_dot_older_, n_.n_v);
  history(d_before_);
  for (double* x : {&h_, &h_w_, &h_older_, &h_done_}) history(*x);
  weights_.remember(history);
  switches_.remember(history, now_.s);
  matrix_.remember(history);
  if (!history.reads()) return;
  if (h_done_ != 0.0) require_size(d_before_.size(), n_.n_v);
  started_ = true;
  next_ = now_;
}

}  // namespace

std::unique_ptr<Integrator> make_generalised_alpha(const Equations& eq, const SolverOptions& options) {
  return std::make_unique<GeneralisedAlpha>(eq, options);
}

}  // namespace flexura::mbs
