// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/linear_correction.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
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
  double m, f, beta, gamma;
};

// Steps that resolve nothing damp it out; those that follow a transient leave its damping alone.
constexpr double kRhoOfRows = 0.4, kRhoOfTransients = 0.8;
constexpr int kFinest = 30;  // a step of a row is halved so often at most
// A row in 2^k steps is worth the inverse: its product with a column is a plain one, triangular solutions pack theirs.
constexpr int kWorthAnInverse = 5;

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
}

void LinearCorrection::factor(double h, double rho, const LinearisedRow& row) {
  if (row.number != 0 && row.number == number_ && std::abs(h - h_) <= 1e-9 * h && rho == rho_) return;
  const Alpha alpha(rho);
  const double share = (1.0 - alpha.f) / (1.0 - alpha.m);
  A_.compute(h > 0.0 ? MatrixXd(row.M + h * alpha.gamma * share * row.D + h * h * alpha.beta * share * row.K)
                     : row.M);
  inverse_.resize(0, 0);
  number_ = row.number;
  h_ = h;
  rho_ = rho;
}

void LinearCorrection::solve(const MatrixXd& rhs, MatrixXd& x) const {
  if (inverse_.rows() > 0)
    x.noalias() = inverse_ * rhs;
  else
    x = A_.solve(rhs);
}

// G A^-1 G^T with B = A^-1 G^T; a part in 1e12 on its diagonal carries it over dead points and rows that others imply.
void LinearCorrection::factor_schur(const MatrixXd& G, const MatrixXd& B) {
  MatrixXd schur = G * B;
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
      factor_schur(G, B_part_);
    }
    step_once(h, kRhoOfRows, row, G, B_part_, load);
    if (transients && h > 0.0) transients->pass(h);
  };
  if (!transients || !(transients->step() < h)) {
    whole();
  } else {
    // Steps h / 2^k, longer ones where the place in the row allows it.
    MatrixXd B_last, B, force;
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
        if (k >= kWorthAnInverse && inverse_.rows() == 0) inverse_ = A_.inverse();
        if (G.rows() > 0) {
          B = A_.solve(G.transpose());
          if (holds)
            factor_schur(G, B);
          else
            B_last = A_.solve(last_G_.transpose());
        }
        k_last = k;
      }
      force = load;
      if (!jumped) force -= (1.0 - part) * (load - last_load_);
      if (G.rows() > 0 && !holds) {
        G_part_ = last_G_ + part * (G - last_G_);
        B_part_ = B_last + part * (B - B_last);
        factor_schur(G_part_, B_part_);
        step_once(dt, rho, row, G_part_, B_part_, force);
      } else {
        step_once(dt, rho, row, G, B, force);
      }
      transients->pass(dt);
    }
  }
  last_G_ = G;
  last_load_ = load;
}

void LinearCorrection::step_once(double h, double rho, const LinearisedRow& row, const MatrixXd& G,
                                 const MatrixXd& B, const MatrixXd& load) {
  const Alpha alpha(rho);
  rhs_ = load;
  double to_acceleration = 0.0, to_rate = 0.0;
  if (h > 0.0) {
    // auxiliary_new = ((1 - f) acceleration_new + f acceleration - m auxiliary) / (1 - m)
    const double of_acceleration = alpha.f / (1.0 - alpha.m), of_auxiliary = -alpha.m / (1.0 - alpha.m);
    predicted_ = delta_ + h * rate_ +
                 h * h *
                     ((0.5 - alpha.beta + alpha.beta * of_auxiliary) * auxiliary_ +
                      alpha.beta * of_acceleration * acceleration_);
    predicted_rate_ = rate_ + h * ((1.0 - alpha.gamma + alpha.gamma * of_auxiliary) * auxiliary_ +
                                   alpha.gamma * of_acceleration * acceleration_);
    const double share = (1.0 - alpha.f) / (1.0 - alpha.m);
    to_acceleration = h * h * alpha.beta * share;  // delta_new = predicted + to_acceleration acceleration_new
    to_rate = h * alpha.gamma * share;
    rhs_.noalias() -= row.D * predicted_rate_;
    rhs_.noalias() -= row.K * predicted_;
  }
  // [A G^T; G 0] (acceleration, dlambda) = (rhs, 0 or what closes the loops at position level).
  solve(rhs_, next_);
  if (G.rows() > 0) {
    gap_.noalias() = G * next_;
    if (h > 0.0) gap_.noalias() += G * predicted_ / to_acceleration;
    dlambda_ = schur_.solve(gap_);
    next_.noalias() -= B * dlambda_;
  } else {
    dlambda_.resize(0, load.cols());
  }
  if (h > 0.0) {
    delta_ = predicted_ + to_acceleration * next_;
    rate_ = predicted_rate_ + to_rate * next_;
    auxiliary_ = ((1.0 - alpha.f) * next_ + alpha.f * acceleration_ - alpha.m * auxiliary_) / (1.0 - alpha.m);
  } else {
    auxiliary_ = next_;
  }
  acceleration_.swap(next_);
}

}  // namespace flexura::study
