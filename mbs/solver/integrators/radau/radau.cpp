// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/radau/radau.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mbs/solver/accuracy/error_weights.hpp"
#include "mbs/solver/algebra/remembered.hpp"
#include "mbs/solver/integrators/radau/radau_matrices.hpp"
#include "mbs/solver/integrators/radau/radau_stages.hpp"
#include "mbs/solver/integrators/radau/radau_tableau.hpp"
#include "mbs/solver/integrators/switches.hpp"

namespace flexura::mbs {

namespace {

using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr int kMostIterations = 7;
// With a matrix for each stage (radau_stages.hpp) Newton's method goes on for longer, but never quadratically; where it
// is wanted again soon, the next steps begin with it, and where it does not serve it is not tried again for some.
constexpr int kMostStageIterations = 20, kMostStagePasses = 4, kMostStageSteps = 64, kSoonAgain = 4,
              kLongestWait = 1024;
// Tried from one failure in five attempts on: a contact that closes fails now and then.
constexpr double kTroubled = 0.2;
constexpr double kSafety = 0.9;
// Steps follow G. Soederlind's digital filter H211b (ACM TOMS 29 (2003) 1), with the error aimed at as
// kSafety^4 and b = kFilter.  A controller that takes the error to go with h^4 alone makes steps of vibrating
// bodies long and short in turn, every one with new factors: of the steam engine with 20 modes 1460 to 1860
// steps and 50 failures of Newton's method, with this one 1200 to 1300 and 30.  At b = 4 more steps are
// rejected, at b = 8 there are more of them.
constexpr double kFilter = 6.0, kAim = kSafety * kSafety * kSafety * kSafety;
// Newton's method may contract this slowly with the derivatives of an earlier step.  Of a turning engine with
// 20 modes two thirds of them are saved for 6 % more iterations; at 0.2 the iterations cost more than that.
constexpr double kSlow = 0.05;
// Corrections of this part of the error allowed may be left where round-off makes them.
constexpr double kEndOfDescent = 0.1;
// Between the last two nodes, where the polynomial through them lies furthest from what it interpolates.
constexpr double kBetweenNodes = 0.85;

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

class Radau final : public Integrator {
 public:
  Radau(const Equations& eq, const SolverOptions& options)
      : eq_(eq),
        n_(eq.sizes()),
        options_(options),
        weights_(eq, options),
        switches_(eq),
        scratch_(eq.make_scratch()) {
    g_.setZero(n_.n_lambda);
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
  enum class Outcome { converged, slow, diverged };

  void create(const State& s);
  void set_weights();
  double norm(const VectorXd& x) const { return std::sqrt(x.cwiseAbs2().dot(weights2_) / n_norm_); }
  void state_at(double t, State& s);
  void linearise(double h);
  void predict(double h);
  Outcome newton(double h, double t_stop, double& shorter, int& iterations, bool by_stages);
  Outcome newton_by_stages(double h, double t_stop, double& shorter, int& iterations);
  double local_error(double h, bool again);
  double distance_between_nodes(double h);
  void accept(double h, double t_stop, double wanted, double error, double quotient);
  [[noreturn]] void fail(double h, bool converges);
  std::string worst_state() const;

  const Equations& eq_;
  Sizes n_;
  SolverOptions options_;
  RadauTableau k_;
  ErrorWeights weights_;
  SwitchFinder switches_;
  std::unique_ptr<Equations::Scratch> scratch_;
  std::unique_ptr<RadauMatrices> matrices_;
  StabilisedIndex2* form_ = nullptr;     // in matrices_
  std::unique_ptr<RadauStages> stages_;  // once they were wanted
  // Steps to come that begin with them, or that do without; how many the next time, and steps since then.
  int stage_steps_ = 0, stage_wait_ = 0, stage_run_ = 1, stage_span_ = 8, plain_steps_ = kSoonAgain;
  double trouble_rate_ = 0.0;  // failures of Newton's method with one matrix, of some ten attempts
  double loosening_, n_norm_ = 1.0;

  State state_;  // at t_, for its switches
  double t_ = 0.0;
  VectorXd y_, yp_;                                  // at t_
  std::array<VectorXd, 3> Z_;                        // of the step being tried
  RadauPolynomial last_{k_, 0.0, 0.0, {}, {}};       // of the last step
  double h_ = 0.0;                                   // the next step
  bool is_first_ = true;                             // the step is the first from here
  double theta_ = 0.0, convergence_ = 1.0;           // of Newton's method
  double h_accepted_ = 0.0, error_accepted_ = 1e-2;  // for the predictive controller
  bool rejected_ = false;

  std::array<VectorXd, 3> R_;
  VectorXd weights2_, stage_, rate_, step_, rhs_, x_, error_, g_;
  VectorXcd rhs_c_, x_c_;
  StepCounts counts_;
  std::string trouble_;
  VectorXd interpolated_;
};

void Radau::create(const State& s) {
  matrices_ = std::make_unique<RadauMatrices>(eq_, k_, s);
  form_ = &matrices_->form();
  const int n = form_->size();
  for (VectorXd* x :
       {&y_, &yp_, &last_.y_begin, &weights2_, &stage_, &rate_, &step_, &rhs_, &x_, &error_, &interpolated_})
    x->setZero(n);
  rhs_c_.setZero(n);
  x_c_.setZero(n);
  for (auto* three : {&Z_, &last_.Z, &R_})
    for (VectorXd& x : *three) x.setZero(n);
  n_norm_ = std::max(1, form_->at_lambda());
}

void Radau::set_weights() {
  const int n_p = n_.n_p, n_v = n_.n_v, n_c = n_.n_dyn;
  weights_.evaluate(y_.head(n_p), y_.segment(n_p, n_v), y_.segment(form_->at_c(), n_c),
                    weights2_.head(form_->at_a()));
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
    step_.setZero();
    step_.segment(form_->at_v(), n_.n_v) = yp_.segment(form_->at_v(), n_.n_v);
    const double rate = norm(step_) * loosening_ * options_.tolerance;
    h_ = std::min({h_, 1e-4 * duration, rate > 0.0 ? 0.01 / rate : duration});
  }
  last_.h = 0.0;
  matrices_->forget();
  is_first_ = true;
  h_accepted_ = 0.0;
  error_accepted_ = 1e-2;
  convergence_ = 1.0;
  theta_ = 0.0;
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
Radau::Outcome Radau::newton_by_stages(double h, double t_stop, double& shorter, int& iterations) {
  if (!stages_) stages_ = std::make_unique<RadauStages>(eq_, k_, state_);
  predict(h);
  Outcome outcome = Outcome::diverged;
  for (int pass = 0; pass < kMostStagePasses && outcome != Outcome::converged; ++pass) {
    for (int i = 0; i < 3; ++i) {
      stage_ = y_ + Z_[i];
      rate_ = (k_.B(i, 0) * Z_[0] + k_.B(i, 1) * Z_[1] + k_.B(i, 2) * Z_[2]) / h;
      if (!stages_->linearise(i, std::min(t_ + k_.c[i] * h, t_stop), stage_, rate_, h))
        return Outcome::diverged;
    }
    outcome = newton(h, t_stop, shorter, iterations, true);
    if (!Z_[2].allFinite()) return Outcome::diverged;
  }
  theta_ = 1.0;  // nothing is known of the one matrix
  return outcome;
}

Radau::Outcome Radau::newton(double h, double t_stop, double& shorter, int& iterations, bool by_stages) {
  const int most = by_stages ? kMostStageIterations : kMostIterations;
  // Passes in which a triangular matrix may make corrections longer first.
  const int trusted = by_stages ? 3 : 1;
  // A hundredth of the error allowed (RADAU5's choice for tolerances of 1e-4 and less is sqrt(tolerance)).
  const double goal = std::max(10.0 * std::numeric_limits<double>::epsilon() / options_.tolerance, 1e-2);
  convergence_ = std::pow(std::max(convergence_, std::numeric_limits<double>::epsilon()), 0.8);
  double before = 0.0, ratio_before = 0.0;
  shorter = 0.5;
  for (int k = 1; k <= most; ++k) {
    for (int i = 0; i < 3; ++i) {
      stage_ = y_ + Z_[i];
      rate_ = (k_.B(i, 0) * Z_[0] + k_.B(i, 1) * Z_[1] + k_.B(i, 2) * Z_[2]) / h;
      if (!form_->residual(std::min(t_ + k_.c[i] * h, t_stop), stage_, rate_, R_[i])) {
        trouble_ = form_->non_finite();
        return Outcome::diverged;
      }
    }
    if (by_stages) {
      stages_->solve(R_);
    } else {
      rhs_ = k_.v_left(0) * R_[0] + k_.v_left(1) * R_[1] + k_.v_left(2) * R_[2];
      rhs_c_ = k_.w_left(0) * R_[0] + k_.w_left(1) * R_[1] + k_.w_left(2) * R_[2];
      matrices_->solve(rhs_, step_);
      matrices_->solve(rhs_c_, x_c_);
      for (int i = 0; i < 3; ++i) R_[i] = -k_.v(i) * step_ - 2.0 * (k_.w(i) * x_c_).real();
    }
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += R_[i].cwiseAbs2().dot(weights2_);
    const double size = std::sqrt(sum / (3.0 * n_norm_));
    if (!std::isfinite(size)) return Outcome::diverged;
    iterations = k;
    if (k > 1 && reached_round_off(size, before, ratio_before)) {
      convergence_ = 1.0;
      theta_ = std::min(theta_, kSlow);
      return Outcome::converged;
    }
    if (k > 1 && k < most) {
      const double ratio = size / before;
      theta_ = k == 2 ? ratio : std::sqrt(ratio * ratio_before);
      ratio_before = ratio;
      if (theta_ >= 0.99 && (k > trusted || ratio > 10.0)) return Outcome::diverged;
      convergence_ = theta_ < 0.99 ? theta_ / (1.0 - theta_) : 100.0;
      const double at_end =
          convergence_ * size * std::pow(theta_, most - 1 - k) / goal;  // after the last iteration
      if (at_end >= 1.0 && k > trusted) {
        shorter = 0.8 * std::pow(std::clamp(at_end, 1e-4, 20.0), -1.0 / (3 + most - k));
        return Outcome::slow;
      }
    }
    before = std::max(size, std::numeric_limits<double>::epsilon());
    for (int i = 0; i < 3; ++i) Z_[i] += R_[i];
    // Where stiffness may end within the step one small correction proves nothing.
    if (convergence_ * size <= goal && (k > 1 || !weights_.has_narrow_range())) return Outcome::converged;
  }
  return Outcome::slow;
}

double Radau::local_error(double h, bool again) {
  stage_ = (k_.e[0] * Z_[0] + k_.e[1] * Z_[1] + k_.e[2] * Z_[2]) / h;
  const auto estimate = [&] {
    matrices_->solve(rhs_, error_);
    error_.tail(form_->size() - form_->at_a()).setZero();
    return std::max(norm(error_), 1e-10);
  };
  rate_ = stage_ + yp_;
  matrices_->multiply_rates(rate_, rhs_);
  double size = estimate();
  if (again && size >= 1.0) {
    // A second pass through the matrix damps what belongs to stiff components.
    x_ = y_ + error_;
    matrices_->multiply_rates(rate_, rhs_);
    if (form_->residual(t_, x_, yp_, step_)) {
      rhs_ -= step_;
      size = estimate();
    }
  }
  if (weights_.has_narrow_range()) {
    // The matrix takes out of the error what is stiff in it, which may have ended within the step.
    x_ = h / k_.gamma * rate_;
    error_.segment(form_->at_v(), n_.n_v) = x_.segment(form_->at_v(), n_.n_v);
    size = std::max(size, norm(error_));
  }
  return std::isfinite(size) ? size : std::numeric_limits<double>::infinity();
}

// How far the step's polynomial lies from the constraints between its nodes, in units of the error allowed.
// The local error passes through Newton's matrix, which takes out of it what constraints prescribe: a driven
// loop has none at the nodes, however many turns a step takes, but positions, accelerations and forces
// between them would be nonsense.  Both are of order h^4.
double Radau::distance_between_nodes(double h) {
  if (n_.n_lambda == 0) return 0.0;
  stage_ = y_;
  for (int j = 0; j < 3; ++j) stage_ += k_.basis(j, kBetweenNodes) * Z_[j];
  eq_.position_constraints(t_ + kBetweenNodes * h, stage_.head(n_.n_p), *scratch_, g_);
  rhs_.setZero();
  rhs_.tail(n_.n_lambda) = g_;
  matrices_->solve(rhs_, x_);
  x_.tail(x_.size() - n_.n_p).setZero();
  const double size = norm(x_);
  return std::isfinite(size) ? size : std::numeric_limits<double>::infinity();
}

std::string Radau::worst_state() const {
  int i = 0;
  error_.cwiseAbs2().cwiseProduct(weights2_).head(form_->at_a()).maxCoeff(&i);
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
  if (stage_wait_ > 0) --stage_wait_;
  plain_steps_ = stage_steps_ > 0 ? 0 : std::min(plain_steps_ + 1, kSoonAgain);
  if (stage_steps_ > 0 && --stage_steps_ == 0) stage_span_ = 8;
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
  bool wants_tangents = !matrices_->are_fresh(t_) && (!matrices_->has_tangents() || theta_ > kSlow);
  const double wanted = h_;
  for (;;) {
    const double left = t_stop - t_;
    double h = std::min({h_, h_max, left});
    if (left - h < 1e-3 * h)
      h = left;
    else if (left < 2.0 * h)
      h = 0.5 * left;  // two equal steps rather than a long one and a sliver
    trouble_.clear();
    double shorter = 0.25;
    int iterations = 0;
    bool by_stages = false;
    Outcome outcome = Outcome::diverged;
    try {
      if (wants_tangents) {
        linearise(h);
        wants_tangents = false;
      }
      const bool has_factors = matrices_->factor(h);
      if (has_factors && stage_steps_ == 0) {
        predict(h);
        outcome = newton(h, t_stop, shorter, iterations, false);
        trouble_rate_ += 0.1 * ((outcome == Outcome::converged ? 0.0 : 1.0) - trouble_rate_);
      }
      by_stages = has_factors && outcome != Outcome::converged &&
                  (stage_steps_ > 0 ||
                   (stage_wait_ == 0 && (trouble_rate_ > kTroubled || plain_steps_ < kSoonAgain) &&
                    matrices_->are_fresh(t_) && matrices_->are_full()));
      if (by_stages) {
        outcome = newton_by_stages(h, t_stop, shorter, iterations);
        if (outcome == Outcome::converged) {
          if (stage_steps_ == 0) {
            stage_run_ = plain_steps_ < kSoonAgain ? std::min(2 * stage_run_, kMostStageSteps) : 1;
            stage_steps_ = stage_run_;
          }
        } else {
          stage_steps_ = 0;
          stage_wait_ = stage_span_;
          stage_span_ = std::min(2 * stage_span_, kLongestWait);
        }
      }
    } catch (const std::runtime_error& e) {
      trouble_ = e.what();
    }
    if (outcome != Outcome::converged) {
      last_.h = 0.0;  // it led astray
      ++counts_.newton_failures;
      if (h <= h_min) fail(h, false);
      // A matrix from the middle of a step that failed is of no use to steps much shorter.
      wants_tangents =
          !matrices_->are_fresh(t_) || matrices_->ask_for_more() || (rejected_ && matrices_->look_ahead());
      h_ = shorter * h;
      rejected_ = true;
      continue;
    }
    // Rows are moved onto their constraints from ten times the error at the nodes away.
    const double error = std::max(local_error(h, rejected_ || is_first_), 0.1 * distance_between_nodes(h));
    const double factor =
        by_stages
            ? kSafety
            : std::min(kSafety, kSafety * (1 + 2 * kMostIterations) / (iterations + 2 * kMostIterations));
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
  for (double* x :
       {&t_, &last_.t_begin, &last_.h, &h_, &theta_, &convergence_, &h_accepted_, &error_accepted_})
    history(*x);
  history(is_first_);
  history(trouble_rate_);
  for (int* k : {&stage_steps_, &stage_wait_, &stage_run_, &stage_span_, &plain_steps_}) {
    history(*k);
    if (history.reads()) require_between(*k, 0, kLongestWait);
  }
  weights_.remember(history);
  switches_.remember(history, state_);
  matrices_->remember(history);
}

}  // namespace

std::unique_ptr<Integrator> make_radau(const Equations& eq, const SolverOptions& options) {
  return std::make_unique<Radau>(eq, options);
}

}  // namespace flexura::mbs
