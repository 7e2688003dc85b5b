// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/linear_correction.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace flexura::study {
namespace {

using Eigen::MatrixXd;

struct Alpha {
  explicit Alpha(double rho) : m((2.0 * rho - 1.0) / (rho + 1.0)), f(rho / (rho + 1.0)) {
    beta = 0.25 * (1.0 + f - m) * (1.0 + f - m);
    gamma = 0.5 + f - m;
  }
  double share() const { return (1.0 - f) / (1.0 - m); }
  double m, f, beta, gamma;
};

// Steps that resolve nothing damp it out; those that follow a transient leave its damping alone.
constexpr double kRhoOfRows = 0.4, kRhoOfTransients = 0.8;
constexpr int kFinest = 30;  // a step of a row is halved so often at most
// After so many steps with the same factors their operator is worth making: it costs what some thirty of them do.
constexpr int kWorthAnOperator = 16;

}  // namespace

void Transients::add(const Eigen::VectorXd& omega2, const Eigen::VectorXd& damping) {
  for (Eigen::Index i = 0; i < omega2.size(); ++i) {
    const double omega = std::sqrt(std::max(omega2(i), 0.0));
    if (!(omega > 0.0)) continue;
    const double decay = std::max(0.5 * damping(i), kLeastDampingRatio * omega);
    modes_.emplace_back(kDecay / decay, 2.0 * std::numbers::pi / omega / kStepsPerPeriod);
  }
  std::ranges::sort(modes_, {}, [](const auto& mode) { return mode.second; });
  fastest_ = 0;
  pass_those_at_rest();
}

bool Transients::add(const LinearisedRow& row, const MatrixXd& G) {
  constexpr Eigen::Index kMost = 120;
  constexpr double kAtRest = 1e-8;  // of the largest square of a frequency: moves freely
  const Eigen::Index n = row.M.rows();
  if (n == 0 || n > kMost) return false;
  // Of unit masses, in what the constraints leave.
  const Eigen::VectorXd scale = row.M.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  MatrixXd N = MatrixXd::Identity(n, n);
  if (G.rows() > 0) {
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(scale.asDiagonal() * G.transpose());
    N = (qr.householderQ() * N).rightCols(n - qr.rank()).eval();
  }
  if (N.cols() == 0) return false;
  const auto reduced = [&](const MatrixXd& A) {
    const MatrixXd B = N.transpose() * (scale.asDiagonal() * A * scale.asDiagonal()) * N;
    return MatrixXd(0.5 * (B + B.transpose()));
  };
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(reduced(row.K), reduced(row.M));
  if (modes.info() != Eigen::Success || !modes.eigenvalues().allFinite()) return false;
  const MatrixXd& phi = modes.eigenvectors();
  const Eigen::VectorXd damping = (phi.transpose() * reduced(row.D) * phi).diagonal().cwiseMax(0.0);
  const double most = modes.eigenvalues().maxCoeff();
  add((modes.eigenvalues().array() > kAtRest * most).select(modes.eigenvalues(), 0.0), damping);
  return true;
}

void Transients::begin() {
  if (steps_left_ <= 0) return;
  since_ = 0.0;
  fastest_ = 0;
  pass_those_at_rest();
}

void Transients::pass_those_at_rest() {
  while (fastest_ < modes_.size() && !(since_ < modes_[fastest_].first)) ++fastest_;
}

double Transients::step() const {
  return steps_left_ > 0 && fastest_ < modes_.size() ? modes_[fastest_].second
                                                     : std::numeric_limits<double>::infinity();
}

void Transients::pass(double dt) {
  since_ += dt;
  --steps_left_;
  pass_those_at_rest();
}

LinearCorrection::LinearCorrection(Eigen::Index n, Eigen::Index columns) {
  delta_ = rate_ = acceleration_ = auxiliary_ = MatrixXd::Zero(n, columns);
  states_ = state_rates_ = MatrixXd::Zero(0, columns);
}

void LinearCorrection::factor(double h, double rho, const LinearisedRow& row) {
  if (row.number != 0 && row.number == number_ && std::abs(h - h_) <= 1e-9 * h && rho == rho_) return;
  const Alpha alpha(rho);
  if (!(h > 0.0)) {
    A_.compute(row.M);
  } else {
    MatrixXd A = row.M + h * alpha.gamma * alpha.share() * row.D + h * h * alpha.beta * alpha.share() * row.K;
    if (const Eigen::Index n_c = row.Z_c.cols(); n_c > 0) {
      const double implicit = h / (1.0 + rho);
      states_lu_.compute(MatrixXd::Identity(n_c, n_c) - implicit * row.C_c);
      states_by_delta_ = states_lu_.solve(implicit * row.C_p);
      states_by_rate_ = states_lu_.solve(implicit * row.C_v);
      A.noalias() += row.Z_c * (h * alpha.gamma * alpha.share() * states_by_rate_ +
                                h * h * alpha.beta * alpha.share() * states_by_delta_);
    }
    A_.compute(A);
  }
  states_act_ = !row.Z_c.isZero(0.0);
  operator_.clear();
  uses_ = 0;
  number_ = row.number;
  h_ = h;
  rho_ = rho;
}

// Of G A^-1 G^T; a part in 1e12 on its diagonal carries it over dead points and rows that others imply.
void LinearCorrection::factor_schur(MatrixXd schur) {
  const double mean = schur.trace() / static_cast<double>(schur.rows());
  schur.diagonal().array() += 1e-12 * mean;
  schur_.compute(schur);
}

void LinearCorrection::step(double h, const LinearisedRow& row, const MatrixXd& G, const MatrixXd& load,
                            Transients* transients, bool jumped) {
  const auto whole = [&] {
    factor(h, kRhoOfRows, row);
    if (G.rows() > 0) {
      B_part_ = A_.solve(G.transpose());
      factor_schur(G * B_part_);
    }
    step_once(h, kRhoOfRows, row, G, B_part_, load);
    if (transients && h > 0.0) transients->pass(h);
  };
  if (!transients || !(transients->step() < h)) {
    whole();
  } else {
    // Steps h / 2^k, longer ones where the place in the row allows it.
    MatrixXd B_last, B, force;
    std::array<MatrixXd, 3>
        schur;  // with G and B on their ways from the last row: its powers of the part that is gone
    int k_last = -1;
    const bool holds = G.rows() > 0 && G.rows() == last_G_.rows() && G == last_G_;
    for (long place = 0, all = 1L << kFinest; place < all;) {
      const double longest = transients->step();
      int k = 0;
      while (k < kFinest && std::ldexp(h, -k) > longest) ++k;
      while (k < kFinest && place % (all >> k) != 0) ++k;
      const double dt = std::ldexp(h, -k);
      place += all >> k;
      const double part = static_cast<double>(place) / static_cast<double>(all);
      const double rho = dt > longest ? kRhoOfRows : kRhoOfTransients;
      if (k != k_last || rho != rho_) {
        factor(dt, rho, row);
        if (G.rows() > 0) {
          B = A_.solve(G.transpose());
          if (holds) {
            factor_schur(G * B);
          } else {
            B_last = A_.solve(last_G_.transpose());
            const MatrixXd G_change = G - last_G_, B_change = B - B_last;
            schur = {last_G_ * B_last, G_change * B_last + last_G_ * B_change, G_change * B_change};
          }
        }
        k_last = k;
      }
      force = load;
      if (!jumped) force -= (1.0 - part) * (load - last_load_);
      if (G.rows() > 0 && !holds) {
        G_part_ = last_G_ + part * (G - last_G_);
        B_part_ = B_last + part * (B - B_last);
        factor_schur(schur[0] + part * (schur[1] + part * schur[2]));
        if (!states_act_ && !operator_.is_there() && ++uses_ > kWorthAnOperator)
          make_operator(dt, rho, row, {}, {});
        step_once(dt, rho, row, G_part_, B_part_, force);
      } else {
        // Multipliers are those of the row.
        place < all ? step_within_row(dt, rho, row, G, B, force) : step_once(dt, rho, row, G, B, force);
      }
      transients->pass(dt);
    }
  }
  last_G_ = G;
  last_load_ = load;
}

// What a step begins with: delta_new = predicted + to_acceleration acceleration_new.
void LinearCorrection::predict(double h, double rho) {
  const Alpha alpha(rho);
  // auxiliary_new = ((1 - f) acceleration_new + f acceleration - m auxiliary) / (1 - m)
  const double of_acceleration = alpha.f / (1.0 - alpha.m), of_auxiliary = -alpha.m / (1.0 - alpha.m);
  predicted_ = delta_ + h * rate_ +
               h * h *
                   ((0.5 - alpha.beta + alpha.beta * of_auxiliary) * auxiliary_ +
                    alpha.beta * of_acceleration * acceleration_);
  predicted_rate_ = rate_ + h * ((1.0 - alpha.gamma + alpha.gamma * of_auxiliary) * auxiliary_ +
                                 alpha.gamma * of_acceleration * acceleration_);
}

// And ends with, its accelerations known.
void LinearCorrection::correct(double h, double rho) {
  const Alpha alpha(rho);
  delta_ = predicted_ + h * h * alpha.beta * alpha.share() * next_;
  rate_ = predicted_rate_ + h * alpha.gamma * alpha.share() * next_;
  auxiliary_ = ((1.0 - alpha.f) * next_ + alpha.f * acceleration_ - alpha.m * auxiliary_) / (1.0 - alpha.m);
  acceleration_.swap(next_);
}

// States at the end of a step as far as its predicted positions and rates make them.
void LinearCorrection::predict_states(double h, double rho, const LinearisedRow& row) {
  const Eigen::Index n_c = row.Z_c.cols();
  if (states_.rows() != n_c) states_ = state_rates_ = MatrixXd::Zero(n_c, delta_.cols());
  if (n_c == 0 || !(h > 0.0)) return;
  old_states_ = states_ + h * rho / (1.0 + rho) * state_rates_;
  states_ = states_lu_.solve(old_states_);
  states_.noalias() += states_by_delta_ * predicted_;
  states_.noalias() += states_by_rate_ * predicted_rate_;
}

// And what the accelerations of the step add.
void LinearCorrection::correct_states(double h, double rho, const LinearisedRow& row) {
  if (row.Z_c.cols() == 0) return;
  if (h > 0.0) {
    const Alpha alpha(rho);
    states_.noalias() += states_by_delta_ * (h * h * alpha.beta * alpha.share() * acceleration_);
    states_.noalias() += states_by_rate_ * (h * alpha.gamma * alpha.share() * acceleration_);
  }
  state_rates_ = row.C_p * delta_ + row.C_v * rate_ + row.C_c * states_;
}

void LinearCorrection::step_once(double h, double rho, const LinearisedRow& row, const MatrixXd& G,
                                 const MatrixXd& B, const MatrixXd& load) {
  if (h > 0.0) predict(h, rho);
  predict_states(h, rho, row);
  // [A G^T; G 0] (acceleration, dlambda) = (rhs, 0 or what closes the loops at position level).
  if (h > 0.0 && operator_.is_there() && operator_G_.rows() == 0) {
    operator_.apply(load, predicted_rate_, predicted_, next_);
  } else {
    rhs_ = load;
    if (h > 0.0) {
      rhs_.noalias() -= row.D * predicted_rate_;
      rhs_.noalias() -= row.K * predicted_;
      if (states_act_) rhs_.noalias() -= row.Z_c * states_;
    }
    next_ = A_.solve(rhs_);
  }
  if (G.rows() > 0) {
    gap_.noalias() = G * next_;
    const Alpha alpha(rho);
    if (h > 0.0) gap_.noalias() += G * predicted_ / (h * h * alpha.beta * alpha.share());
    dlambda_ = schur_.solve(gap_);
    next_.noalias() -= B * dlambda_;
  } else {
    dlambda_.resize(0, load.cols());
  }
  if (h > 0.0) {
    correct(h, rho);
  } else {
    auxiliary_ = next_;
    acceleration_.swap(next_);
  }
  correct_states(h, rho, row);
}

// Of G that stays: with P = I - B (G B)^-1 G
//   next = P A^-1 (load - D rate - K position) - B (G B)^-1 G position / to_acceleration;
// without one P = I, and the rest is step_once's.
void LinearCorrection::make_operator(double h, double rho, const LinearisedRow& row, const MatrixXd& G,
                                     const MatrixXd& B) {
  MatrixXd W_load = A_.inverse(), closing;
  if (G.rows() > 0) {
    closing = B * schur_.solve(G);
    W_load -= closing * W_load.eval();
  }
  const MatrixXd W_rate = -W_load * row.D;
  MatrixXd W_position = -W_load * row.K;
  const Alpha alpha(rho);
  if (G.rows() > 0) W_position -= closing / (h * h * alpha.beta * alpha.share());
  operator_.set({&W_load, &W_rate, &W_position});
  operator_G_ = G;
}

// The same, G that of the row before, and without multipliers.
void LinearCorrection::step_within_row(double h, double rho, const LinearisedRow& row, const MatrixXd& G,
                                       const MatrixXd& B, const MatrixXd& load) {
  if (!(operator_.is_there() && G.rows() == operator_G_.rows() && (G.rows() == 0 || G == operator_G_))) {
    if (states_act_ || ++uses_ <= kWorthAnOperator) return step_once(h, rho, row, G, B, load);
    make_operator(h, rho, row, G, B);
  }
  predict(h, rho);
  predict_states(h, rho, row);
  operator_.apply(load, predicted_rate_, predicted_, next_);
  correct(h, rho);
  correct_states(h, rho, row);
}

}  // namespace flexura::study
