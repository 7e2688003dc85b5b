// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/radau/radau.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mbs/solver/accuracy/error_weights.hpp"
#include "mbs/solver/algebra/remembered.hpp"
#include "mbs/solver/integrators/radau/radau_errors.hpp"
#include "mbs/solver/integrators/radau/radau_matrices.hpp"
#include "mbs/solver/integrators/radau/radau_newton.hpp"
#include "mbs/solver/integrators/radau/radau_schedule.hpp"
#include "mbs/solver/integrators/radau/radau_stages.hpp"
#include "mbs/solver/integrators/radau/radau_tableau.hpp"
#include "mbs/solver/integrators/switches.hpp"

namespace flexura::mbs {

namespace {

using Eigen::VectorXd;

constexpr int kMostIterations = 7;
// With a matrix for each stage (radau_stages.hpp) Newton's method goes on for longer, but never quadratically.
constexpr int kMostStageIterations = 20, kMostStagePasses = 4;
constexpr double kSafety = 0.9;
// Steps follow G. Soederlind's digital filter H211b (ACM TOMS 29 (2003) 1), with the error aimed at as
// kSafety^4 and b = kFilter.  A controller that takes the error to go with h^4 alone makes steps of vibrating
// bodies long and short in turn, every one with new factors: of the steam engine with 20 modes 1460 to 1860
// steps and 50 failures of Newton's method, with this one 1200 to 1300 and 30.  At b = 4 more steps are
// rejected, at b = 8 there are more of them.
constexpr double kFilter = 6.0, kAim = kSafety * kSafety * kSafety * kSafety;
class Radau final : public Integrator {
 public:
  Radau(const Equations& eq, const SolverOptions& options)
      : eq_(eq), n_(eq.sizes()), options_(options), weights_(eq, options), switches_(eq) {
    loosening_ = 0.1 * std::pow(options.tolerance, -1.0 / 3.0);
  }

  void start(const State& s, const VectorXd& v_dot) override;
  StepEnd step(double t_stop) override;
  void interpolate(double t, State& s, VectorXd& v_dot) override;
  StepCounts counts() const override {
    StepCounts c = counts_;
    if (form_) c.evaluations = form_->evaluations();
    if (matrices_) c.jacobians = matrices_->linearised();
    if (stages_) {
      c.evaluations += stages_->evaluations();
      c.jacobians += stages_->linearised();
    }
    return c;
  }
  void remember(History& history) override;

 private:
  using Outcome = RadauNewton::Outcome;
  /// What an attempt came to, and the part of the step to try next where it failed.
  struct Attempt {
    Outcome outcome = Outcome::diverged;
    double shorter = 0.25;
    int iterations = 0;
  };

  void create(const State& s);
  void set_weights();
  double norm(const VectorXd& x) const { return std::sqrt(x.cwiseAbs2().dot(weights2_) / n_norm_); }
  void state_at(double t, State& s);
  void linearise(double h);
  void predict(double h);
  void newton(double h, double t_stop, bool by_stages, Attempt& attempt);
  void newton_by_stages(double h, double t_stop, Attempt& attempt);
  void accept(double h, double t_stop, double wanted, double error, double quotient);
  [[noreturn]] void fail(double h, bool converges);
  std::string worst_state() const;

  const Equations& eq_;
  Sizes n_;
  SolverOptions options_;
  RadauTableau k_;
  ErrorWeights weights_;
  SwitchFinder switches_;
  std::unique_ptr<RadauMatrices> matrices_;
  StabilisedIndex2* form_ = nullptr;     // in matrices_
  std::unique_ptr<RadauStages> stages_;  // once they were wanted
  StageSchedule schedule_;
  std::unique_ptr<RadauNewton> newton_;
  std::unique_ptr<RadauErrors> errors_;
  double loosening_, n_norm_ = 1.0;

  State state_;  // at t_, for its switches
  double t_ = 0.0;
  VectorXd y_, yp_;                                  // at t_
  std::array<VectorXd, 3> Z_;                        // of the step being tried
  RadauPolynomial last_{k_, 0.0, 0.0, {}, {}};       // of the last step
  double h_ = 0.0;                                   // the next step
  bool is_first_ = true;                             // the step is the first from here
  double h_accepted_ = 0.0, error_accepted_ = 1e-2;  // for the predictive controller
  bool rejected_ = false;

  VectorXd weights2_, stage_, rate_;
  StepCounts counts_;
  std::string trouble_;
  VectorXd interpolated_;
};

void Radau::create(const State& s) {
  matrices_ = std::make_unique<RadauMatrices>(eq_, k_, s);
  form_ = &matrices_->form();
  const int n = form_->size();
  for (VectorXd* x : {&y_, &yp_, &last_.y_begin, &weights2_, &stage_, &rate_, &interpolated_}) x->setZero(n);
  errors_ = std::make_unique<RadauErrors>(eq_, k_, *matrices_);
  newton_ = std::make_unique<RadauNewton>(k_, *form_, loosening_ * options_.tolerance);
  for (auto* three : {&Z_, &last_.Z})
    for (VectorXd& x : *three) x.setZero(n);
  n_norm_ = std::max(1, form_->at_lambda());
}

void Radau::set_weights() {
  const int n_p = n_.n_p, n_v = n_.n_v, n_c = n_.n_dyn;
  weights_.evaluate(y_.head(n_p), y_.segment(n_p, n_v), y_.segment(form_->at_c(), n_c),
                    weights2_.head(form_->at_a()), h_);
  weights2_.head(form_->at_a()) /= loosening_;
  for (int i = form_->at_a(); i < form_->at_lambda(); ++i)
    weights2_(i) = 1.0 / (loosening_ * options_.tolerance * (std::abs(y_(i)) + options_.absolute_factor));
  weights2_.tail(form_->size() - form_->at_lambda()).setZero();
  weights2_.array() *= weights2_.array();
}

void Radau::start(const State& s, const VectorXd& v_dot) {
  const double duration = options_.end_time - options_.start_time;
  if (!form_) {
    create(s);
    h_ = duration;
  } else {
    ++counts_.restarts;
    form_->set_start(s);
    if (stages_) stages_->set_start(s);
  }
  state_ = s;
  t_ = s.t;
  weights_.start(s, v_dot);
  form_->pack(s, v_dot, y_, yp_);
  set_weights();
  if (options_.first_step > 0.0) {
    h_ = options_.first_step;
  } else {
    // A step over which the velocities change by a hundredth of what their weights are relative to.
    rate_.setZero();
    rate_.segment(form_->at_v(), n_.n_v) = yp_.segment(form_->at_v(), n_.n_v);
    const double rate = norm(rate_) * loosening_ * options_.tolerance;
    h_ = std::min({h_, 1e-4 * duration, rate > 0.0 ? 0.01 / rate : duration});
  }
  last_.h = 0.0;
  matrices_->forget();
  is_first_ = true;
  h_accepted_ = 0.0;
  error_accepted_ = 1e-2;
  newton_->start();
  rejected_ = false;
  switches_.start(state_);
}

// In the middle of the step to come, by the last step's polynomial: there the frozen matrix is nearest to
// those of the stages, and Newton's method converges twice as fast as with the one at the beginning.
void Radau::linearise(double h) {
  if (last_.h == 0.0) {
    matrices_->linearise(t_, t_, y_, yp_);
    return;
  }
  const double ahead = 0.5 * std::min(h, last_.h), x = 1.0 + ahead / last_.h;
  last_.value(x, stage_);
  last_.rate(x, 0, form_->size(), rate_);
  matrices_->linearise(t_, t_ + ahead, stage_, rate_);
}

// Stage values from the last step's polynomial, or along the tangent.
void Radau::predict(double h) {
  for (int i = 0; i < 3; ++i) {
    if (last_.h == 0.0) {
      Z_[i].setZero();
      Z_[i].head(form_->at_a()) = k_.c[i] * h * yp_.head(form_->at_a());
    } else {
      last_.value(1.0 + k_.c[i] * h / last_.h, Z_[i]);
      Z_[i] -= y_;
    }
  }
}

// Stages from the last step's polynomial or along the tangent, and the derivatives there.
void Radau::newton_by_stages(double h, double t_stop, Attempt& attempt) {
  if (!stages_) stages_ = std::make_unique<RadauStages>(eq_, k_, state_);
  predict(h);
  attempt.outcome = Outcome::diverged;
  for (int pass = 0; pass < kMostStagePasses && attempt.outcome != Outcome::converged; ++pass) {
    bool is_finite = true;
    for (int i = 0; i < 3 && is_finite; ++i) {
      stage_ = y_ + Z_[i];
      rate_ = (k_.B(i, 0) * Z_[0] + k_.B(i, 1) * Z_[1] + k_.B(i, 2) * Z_[2]) / h;
      is_finite = stages_->linearise(i, std::min(t_ + k_.c[i] * h, t_stop), stage_, rate_, h);
    }
    if (is_finite) newton(h, t_stop, true, attempt);
    if (!is_finite || !Z_[2].allFinite()) {
      attempt.outcome = Outcome::diverged;
      return;
    }
  }
  newton_->doubt_matrix();
}

void Radau::newton(double h, double t_stop, bool by_stages, Attempt& attempt) {
  attempt.shorter = 0.5;  // also where the equations throw
  const RadauNewton::Step step{t_, h, t_stop, y_, weights2_, n_norm_, weights_.has_narrow_range()};
  // Of a triangular matrix the corrections may grow for three passes first.
  const RadauNewton::Result result =
      by_stages ? newton_->iterate(
                      step, kMostStageIterations, 3, [this](auto& R) { stages_->solve(R); }, Z_)
                : newton_->iterate(
                      step, kMostIterations, 1, [this](auto& R) { matrices_->solve(R); }, Z_);
  attempt = {result.outcome, result.shorter, result.iterations};
  if (!result.trouble.empty()) trouble_ = result.trouble;
}

std::string Radau::worst_state() const {
  int i = 0;
  errors_->last().cwiseAbs2().cwiseProduct(weights2_).head(form_->at_a()).maxCoeff(&i);
  return i < form_->at_v()   ? eq_.name_of_position(i)
         : i < form_->at_c() ? eq_.name_of_velocity(i - form_->at_v())
                             : eq_.name_of_dynamic(i - form_->at_c());
}

void Radau::fail(double h, bool converges) {
  if (!trouble_.empty()) throw IntegrationError(trouble_);
  throw IntegrationError(
      fmt::format("{} at t = {:.9g} s with a step of {:.3g} s; the state in trouble is \"{}\": a force jumps "
                  "there, give it a switch or smooth it, or the constraints lose rank there",
                  converges ? "the error test keeps failing" : "Newton's method does not converge", t_, h,
                  worst_state()));
}

/// Takes the step over and chooses the next; `wanted` was asked for before it was cut to fit t_stop.
void Radau::accept(double h, double t_stop, double wanted, double error, double quotient) {
  ++counts_.steps;
  is_first_ = false;
  schedule_.count_accepted_step();
  matrices_->count_accepted_step();
  if (h_accepted_ > 0.0)
    quotient = std::max(quotient, std::pow(error * error_accepted_ / (kAim * kAim), 0.25 / kFilter) *
                                      std::pow(h / h_accepted_, 1.0 / kFilter));
  h_accepted_ = h;
  error_accepted_ = error;
  last_.t_begin = t_;
  last_.h = h;
  last_.y_begin = y_;
  last_.Z.swap(Z_);
  y_ += last_.Z[2];
  yp_ = (k_.B(2, 0) * last_.Z[0] + k_.B(2, 1) * last_.Z[1] + k_.B(2, 2) * last_.Z[2]) / h;
  t_ = t_ + h >= t_stop ? t_stop : t_ + h;
  weights_.take(y_.head(n_.n_p), y_.segment(form_->at_v(), n_.n_v));
  double next = h / quotient;
  if (rejected_) next = std::min(next, h);
  // A last step cut short says nothing against the one before it.
  if (!rejected_ && h < 0.9 * wanted && next < wanted) next = wanted;
  rejected_ = false;
  // A slightly longer step does not pay for new factors.
  h_ = next >= h && next <= 1.2 * h ? h : next;
}

StepEnd Radau::step(double t_stop) {
  const double duration = options_.end_time - options_.start_time;
  const double h_max = options_.longest_step();
  const double h_min = options_.min_step > 0.0 ? options_.min_step : 1e-12 * duration;
  set_weights();
  bool wants_tangents = !matrices_->are_fresh(t_) && (!matrices_->has_tangents() || newton_->is_slow());
  const double wanted = h_;
  for (;;) {
    const double left = t_stop - t_;
    double h = std::min({h_, h_max, left});
    if (left - h < 1e-3 * h)
      h = left;
    else if (left < 2.0 * h)
      h = 0.5 * left;  // two equal steps rather than a long one and a sliver
    trouble_.clear();
    bool by_stages = false;
    Attempt attempt;
    try {
      if (wants_tangents) {
        linearise(h);
        wants_tangents = false;
      }
      const bool has_factors = matrices_->factor(h);
      if (has_factors && !schedule_.begins_with_stages()) {
        predict(h);
        newton(h, t_stop, false, attempt);
        schedule_.take_plain(attempt.outcome == Outcome::converged);
      }
      by_stages = has_factors && attempt.outcome != Outcome::converged &&
                  schedule_.wants_stages(matrices_->are_fresh(t_) && matrices_->are_full());
      if (by_stages) {
        newton_by_stages(h, t_stop, attempt);
        schedule_.take_stages(attempt.outcome == Outcome::converged);
      }
    } catch (const std::runtime_error& e) {
      trouble_ = e.what();
    }
    if (attempt.outcome != Outcome::converged) {
      last_.h = 0.0;  // it led astray
      ++counts_.newton_failures;
      if (h <= h_min) fail(h, false);
      // A matrix from the middle of a step that failed is of no use to steps much shorter.
      wants_tangents =
          !matrices_->are_fresh(t_) || matrices_->ask_for_more() || (rejected_ && matrices_->look_ahead());
      h_ = attempt.shorter * h;
      rejected_ = true;
      continue;
    }
    // Rows are moved onto their constraints from ten times the error at the nodes away.
    const RadauErrors::Step tried{t_, h, y_, yp_, weights2_, Z_, n_norm_, weights_.has_narrow_range()};
    const double error =
        std::max(errors_->local(tried, rejected_ || is_first_), 0.1 * errors_->between_nodes(tried));
    const double factor = by_stages ? kSafety
                                    : std::min(kSafety, kSafety * (1 + 2 * kMostIterations) /
                                                            (attempt.iterations + 2 * kMostIterations));
    double quotient = std::clamp(std::pow(error, 0.25) / factor, 0.125, 5.0);
    if (error >= 1.0) {
      last_.h = 0.0;
      ++counts_.error_failures;
      if (h <= h_min) fail(h, true);
      h_ = is_first_ ? 0.1 * h : h / quotient;
      rejected_ = true;
      wants_tangents = !matrices_->are_fresh(t_);
      continue;
    }
    accept(h, t_stop, wanted, error, quotient);
    break;
  }
  StepEnd end{last_.t_begin, t_, {}};
  switches_.search(end, [&](double t, State& s) { state_at(t, s); });
  return end;
}

void Radau::state_at(double t, State& s) {
  if (last_.h == 0.0) {
    form_->unpack(t_, y_, s);
    return;
  }
  last_.value((t - last_.t_begin) / last_.h, interpolated_);
  form_->unpack(t, interpolated_, s);
}

void Radau::interpolate(double t, State& s, VectorXd& v_dot) {
  state_at(t, s);
  if (last_.h == 0.0)
    v_dot = yp_.segment(form_->at_v(), n_.n_v);
  else
    last_.rate((t - last_.t_begin) / last_.h, form_->at_v(), n_.n_v, v_dot);
}

void Radau::remember(History& history) {
  if (!history.reads() && !form_) return;  // it never started
  mbs::remember(history, state_, n_);
  if (history.reads()) {
    create(state_);
    form_->set_start(state_);
  }
  for (VectorXd* x : {&y_, &yp_, &last_.Z[0], &last_.Z[1], &last_.Z[2], &last_.y_begin})
    mbs::remember(history, *x, form_->size());
  for (double* x : {&t_, &last_.t_begin, &last_.h, &h_}) history(*x);
  newton_->remember(history);
  for (double* x : {&h_accepted_, &error_accepted_}) history(*x);
  history(is_first_);
  schedule_.remember(history);
  weights_.remember(history);
  switches_.remember(history, state_);
  matrices_->remember(history);
}

}  // namespace

std::unique_ptr<Integrator> make_radau(const Equations& eq, const SolverOptions& options) {
  return std::make_unique<Radau>(eq, options);
}

}  // namespace flexura::mbs
