// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/linear_correction.hpp"

#include <cmath>

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

constexpr double kRhoInf = 0.4;

}  // namespace

LinearCorrection::LinearCorrection(Eigen::Index n, Eigen::Index columns) {
  delta_ = rate_ = acceleration_ = auxiliary_ = MatrixXd::Zero(n, columns);
}

void LinearCorrection::step(double h, const LinearisedRow& row, const MatrixXd& G, const MatrixXd& load) {
  const Alpha alpha(kRhoInf);
  MatrixXd rhs = load, predicted, predicted_rate;
  double to_acceleration = 0.0, to_rate = 0.0;
  if (h > 0.0) {
    // auxiliary_new = ((1 - f) acceleration_new + f acceleration - m auxiliary) / (1 - m)
    const MatrixXd carried = (alpha.f * acceleration_ - alpha.m * auxiliary_) / (1.0 - alpha.m);
    predicted = delta_ + h * rate_ + h * h * ((0.5 - alpha.beta) * auxiliary_ + alpha.beta * carried);
    predicted_rate = rate_ + h * ((1.0 - alpha.gamma) * auxiliary_ + alpha.gamma * carried);
    const double share = (1.0 - alpha.f) / (1.0 - alpha.m);
    to_acceleration = h * h * alpha.beta * share;  // delta_new = predicted + to_acceleration acceleration_new
    to_rate = h * alpha.gamma * share;
    rhs.noalias() -= row.D * predicted_rate;
    rhs.noalias() -= row.K * predicted;
  }
  if (row.number == 0 || row.number != number_ || std::abs(h - h_) > 1e-9 * h) {
    A_.compute(h > 0.0 ? MatrixXd(row.M + to_rate * row.D + to_acceleration * row.K) : row.M);
    number_ = row.number;
    h_ = h;
  }
  // [A G^T; G 0] (acceleration, dlambda) = (rhs, 0 or what closes the loops at position level), by the Schur
  // complement; a part in 1e12 on its diagonal carries it over dead points and rows that others imply.
  MatrixXd acceleration_new = A_.solve(rhs);
  if (G.rows() > 0) {
    const MatrixXd B = A_.solve(G.transpose());
    MatrixXd schur = G * B;
    const double mean = schur.trace() / static_cast<double>(schur.rows());
    schur.diagonal().array() += 1e-12 * mean;
    MatrixXd gap = G * acceleration_new;
    if (h > 0.0) gap += G * predicted / to_acceleration;
    dlambda_ = Eigen::PartialPivLU<MatrixXd>(schur).solve(gap);
    acceleration_new.noalias() -= B * dlambda_;
  } else {
    dlambda_.resize(0, load.cols());
  }
  if (h > 0.0) {
    delta_ = predicted + to_acceleration * acceleration_new;
    rate_ = predicted_rate + to_rate * acceleration_new;
    auxiliary_ = ((1.0 - alpha.f) * acceleration_new + alpha.f * acceleration_ - alpha.m * auxiliary_) /
                 (1.0 - alpha.m);
  } else {
    auxiliary_ = acceleration_new;
  }
  acceleration_ = std::move(acceleration_new);
}

}  // namespace flexura::study
