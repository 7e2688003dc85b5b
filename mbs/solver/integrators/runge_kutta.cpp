// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/runge_kutta.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mbs/solver/accuracy/error_weights.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/finite.hpp"
#include "mbs/solver/algebra/remembered.hpp"
#include "mbs/solver/integrators/switches.hpp"
#include "mbs/solver/position/projection.hpp"

namespace flexura::mbs {

namespace {

// Dormand-Prince 5(4): nodes, coefficients; the last row is the solution of order 5 (first same as last).
constexpr int kStages = 7;
constexpr double kNode[kStages] = {0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0};
constexpr double kA[kStages][6] = {{},
                                   {1.0 / 5},
                                   {3.0 / 40, 9.0 / 40},
                                   {44.0 / 45, -56.0 / 15, 32.0 / 9},
                                   {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                                   {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                                   {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
// Order 5 minus order 4.
constexpr double kError[kStages] = {71.0 / 57600,      0.0,        -71.0 / 16695, 71.0 / 1920,
                                    -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
// Continuous extension.
constexpr double kDense[kStages] = {-12715105075.0 / 11282082432,  0.0,
                                    87487479700.0 / 32700410799,   -10690763975.0 / 1880347072,
                                    701980252875.0 / 199316789632, -1453857185.0 / 822651844,
                                    69997945.0 / 29380423};

class RungeKutta final : public Integrator {
 public:
  RungeKutta(const Equations& eq, const SolverOptions& options)
      : eq_(eq),
        n_(eq.sizes()),
        options_(options),
        accelerations_(eq),
        projector_(eq),
        weights_(eq, options),
        switches_(eq) {
    const int n_y = n_.n_p + n_.n_v + n_.n_dyn;
    for (Eigen::VectorXd& k : k_) k.setZero(n_y);
    for (Eigen::VectorXd& d : dense_) d.setZero(n_y);
    y_.setZero(n_y);
    y_new_.setZero(n_y);
    w_.setZero(n_y);
    error_.setZero(n_y);
  }

  void start(const State& s, const Eigen::VectorXd& v_dot) override {
    if (started_) ++counts_.restarts;
    started_ = true;
    state_ = stage_ = s;
    pack(s, y_);
    rates(s.t, y_, k_[0]);
    take_multipliers();
    weights_.start(s, v_dot);
    switches_.start(s);
    if (options_.fixed_step > 0.0)
      h_ = options_.fixed_step;
    else if (options_.first_step > 0.0)
      h_ = options_.first_step;
    else
      h_ = first_step();
  }

  StepEnd step(double t_stop) override;

  void interpolate(double t, State& s, Eigen::VectorXd& v_dot) override {
    if (t == state_.t && has_rates_) {
      s = state_;
      v_dot = k_[0].segment(n_.n_p, n_.n_v);
      return;
    }
    unpack(t, s);
    accelerations_.solve(s, v_dot);
    ++counts_.evaluations;
  }

  StepCounts counts() const override { return counts_; }

  void remember(History& history) override {
    for (State* x : {&state_, &stage_}) mbs::remember(history, *x, n_);
    for (Eigen::VectorXd* x : {&y_, &k_[0]}) mbs::remember(history, *x, error_.size());
    for (Eigen::VectorXd& d : dense_) mbs::remember(history, d, error_.size());
    for (double* x : {&h_, &h_done_, &t_begin_, &error_before_}) history(*x);
    weights_.remember(history);
    switches_.remember(history, state_);
    if (history.reads()) started_ = has_rates_ = true;
  }

 private:
  void pack(const State& s, Eigen::VectorXd& y) const { y << s.p, s.v, s.c; }
  void set(double t, const Eigen::VectorXd& y, State& s) const {
    s.t = t;
    s.p = y.head(n_.n_p);
    s.v = y.segment(n_.n_p, n_.n_v);
    s.c = y.tail(n_.n_dyn);
  }
  void rates(double t, const Eigen::VectorXd& y, Eigen::VectorXd& k) {
    set(t, y, stage_);
    accelerations_.solve(stage_, v_dot_);
    ++counts_.evaluations;
    eq_.kinematic(stage_.p, stage_.v, k.head(n_.n_p));
    k.segment(n_.n_p, n_.n_v) = v_dot_;
    k.tail(n_.n_dyn) = accelerations_.c_rate();
  }
  // After rates() at state_.
  void take_multipliers() {
    state_.lambda = stage_.lambda;
    state_.a = stage_.a;
    has_rates_ = true;
  }
  // y(t_begin + theta h) by the continuous extension; the projections' small change grows with theta.
  void unpack(double t, State& s) {
    const double theta = h_done_ > 0.0 ? (t - t_begin_) / h_done_ : 1.0, other = 1.0 - theta;
    error_ = dense_[0] + theta * (dense_[1] + other * (dense_[2] + theta * (dense_[3] + other * dense_[4])));
    s.root = state_.root;
    s.u = state_.u;
    s.lambda = state_.lambda;
    s.a = state_.a;
    set(t, error_, s);
  }
  double first_step();
  double try_step(double h, double t_stop);  // the error in units of the allowed one

  const Equations& eq_;
  Sizes n_;
  SolverOptions options_;
  AccelerationSolver accelerations_;
  Projector projector_;
  ErrorWeights weights_;
  SwitchFinder switches_;
  std::array<Eigen::VectorXd, kStages> k_;
  std::array<Eigen::VectorXd, 5> dense_;
  Eigen::VectorXd y_, y_new_, w_, error_, v_dot_;
  State state_, stage_, projected_;
  StepCounts counts_;
  double h_ = 0.0, h_done_ = 0.0, t_begin_ = 0.0, error_before_ = 1e-4;
  bool started_ = false;
  bool last_stage_is_end_ = false;
  bool has_rates_ = false;  // k_[0], lambda and a belong to state_
};

double RungeKutta::first_step() {
  // Hairer, Norsett, Wanner I, II.4: a step over which Euler's method changes the state by a hundredth of its
  // weight.
  weights_.evaluate(state_.p, state_.v, state_.c, w_);
  const double rate = k_[0].cwiseProduct(w_).norm(), duration = options_.end_time - options_.start_time;
  return std::min(1e-3 * duration, rate > 0.0
                                       ? 0.5 / std::max(rate * std::pow(options_.tolerance, 0.8), 1e-300)
                                       : 1e-3 * duration);
}

double RungeKutta::try_step(double h, double t_stop) {
  for (int i = 1; i < kStages; ++i) {
    y_new_ = y_;
    for (int j = 0; j < i; ++j)
      if (kA[i][j] != 0.0) y_new_ += h * kA[i][j] * k_[j];
    if (!y_new_.allFinite()) return std::numeric_limits<double>::infinity();
    if (i + 1 < kStages) rates(std::min(state_.t + kNode[i] * h, t_stop), y_new_, k_[i]);
  }
  // The last stage sits at the new point; it is taken before the projection, as the error formula wants it.
  // Round-off must not take it past a jump.
  rates(std::min(state_.t + h, t_stop), y_new_, k_[kStages - 1]);
  error_.setZero();
  for (int i = 0; i < kStages; ++i)
    if (kError[i] != 0.0) error_ += h * kError[i] * k_[i];
  set(state_.t + h, y_new_, stage_);
  weights_.evaluate(stage_.p, stage_.v, stage_.c, w_);
  const double size =
      error_.cwiseProduct(w_).norm() / std::sqrt(static_cast<double>(std::max<long>(1, w_.size())));
  return std::isfinite(size) ? size : std::numeric_limits<double>::infinity();
}

StepEnd RungeKutta::step(double t_stop) {
  const double duration = options_.end_time - options_.start_time;
  const double h_max = options_.longest_step();
  const double h_min = options_.min_step > 0.0 ? options_.min_step : 1e-12 * duration;
  const bool fixed = options_.fixed_step > 0.0;
  std::string trouble;
  for (;;) {
    const double left = t_stop - state_.t;
    double h = std::min({h_, h_max, left});
    if (left - h < 1e-3 * h) h = left;  // no sliver of a step at the end
    double size = std::numeric_limits<double>::infinity();
    bool projected = false;
    try {
      size = try_step(h, t_stop);
      if (fixed && std::isfinite(size)) size = 0.0;
      if (size <= 1.0) {
        projected_ = stage_;
        projected = projector_.project(projected_);
        if (!projected) size = std::numeric_limits<double>::infinity();
      }
    } catch (const std::runtime_error& e) {
      trouble = e.what();
    }
    if (size <= 1.0 && projected) {
      t_begin_ = state_.t;
      h_done_ = h;
      // Continuous extension, with the projected end.
      pack(projected_, error_);
      last_stage_is_end_ = error_ == y_new_;
      y_new_ = error_;
      dense_[0] = y_;
      dense_[1] = y_new_ - y_;
      dense_[2] = h * k_[0] - dense_[1];
      dense_[3] = dense_[1] - h * k_[kStages - 1] - dense_[2];
      dense_[4].setZero();
      for (int i = 0; i < kStages; ++i)
        if (kDense[i] != 0.0) dense_[4] += h * kDense[i] * k_[i];
      if (!fixed) {
        const double growth = 0.9 * std::pow(std::max(size, 1e-10), -0.17) * std::pow(error_before_, 0.04);
        // A last step cut short by the end time says nothing against the step before it.
        h_ = std::max(h * std::clamp(growth, 0.2, 5.0),
                      std::min(h_, h_max) * (h == left && h < h_ ? 1.0 : 0.0));
        error_before_ = std::max(size, 1e-4);
      }
      break;
    }
    ++counts_.error_failures;
    if (h <= h_min || fixed) {
      if (!trouble.empty()) throw IntegrationError(trouble);
      throw IntegrationError(
          fmt::format("the explicit integrator stops at t = {:.9g} s with a step of {:.3g} s: a force jumps "
                      "there or the model is "
                      "stiff; use method = \"ida\"{}",
                      state_.t, h, fixed ? " or a smaller fixed_step" : ""));
    }
    h_ = std::isfinite(size) ? h * std::clamp(0.9 * std::pow(size, -0.2), 0.1, 0.9) : 0.25 * h;
  }
  ++counts_.steps;
  StepEnd end;
  end.t_begin = t_begin_;
  end.t_end = t_begin_ + h_done_ >= t_stop ? t_stop : t_begin_ + h_done_;
  stage_.root = state_.root;
  switches_.search(end, [&](double t, State& s) { unpack(t, s); });
  if (end.roots.empty()) {
    state_.t = end.t_end;
    y_ = y_new_;
    set(end.t_end, y_, state_);
    weights_.take(state_.p, state_.v);
    // First same as last, where the projection found nothing to do.
    if (last_stage_is_end_)
      k_[0].swap(k_[kStages - 1]);
    else
      rates(end.t_end, y_, k_[0]);
    take_multipliers();
  } else {
    unpack(end.t_end, state_);
    has_rates_ = false;
  }
  return end;
}

}  // namespace

std::unique_ptr<Integrator> make_runge_kutta(const Equations& eq, const SolverOptions& options) {
  return std::make_unique<RungeKutta>(eq, options);
}

}  // namespace flexura::mbs
