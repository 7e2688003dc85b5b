// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/eigen_problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::linalg {

namespace {
// Round-off adds up at random and stays below the bound (0.4 to 0.7 of it on slender and on coarse parts);
// the factors of K bring a few times that.
constexpr double kAboveRoundOff = 4.0;
}  // namespace

void trim(EigenPairs& pairs, const EigenRequest& request) {
  Eigen::Index keep = std::min<Eigen::Index>(request.count, pairs.omega2.size());
  while (keep < pairs.omega2.size() && pairs.omega2(keep) <= request.omega2_max) ++keep;
  while (keep > 0 && keep < pairs.omega2.size() &&
         pairs.omega2(keep) - pairs.omega2(keep - 1) < kClusterGap * std::abs(pairs.omega2(keep)))
    ++keep;
  pairs.omega2_next =
      keep < pairs.omega2.size() ? pairs.omega2(keep) : std::numeric_limits<double>::infinity();
  pairs.omega2.conservativeResize(keep);
  pairs.Phi.conservativeResize(Eigen::NoChange, keep);
}

bool is_accurate(const EigenPairs& pairs, double tolerance) {
  return (pairs.residual.array() <= (kAboveRoundOff * pairs.round_off.array()).max(tolerance)).all();
}

Eigen::MatrixXd EigenProblem::inner(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                    const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  Eigen::MatrixXd C = transpose_times(A, B);
  if (sum) sum(C.data(), C.size());
  return C;
}

void orthonormalise(const EigenProblem& problem, Eigen::MatrixXd& Phi) {
  // Some columns, then some rows at a time: Phi may be most of the memory, and is not to be there three times.
  constexpr Eigen::Index kHeight = 16384;
  const Eigen::Index count = Phi.cols(), most = std::max<Eigen::Index>(16, count / 8);
  Eigen::MatrixXd gram(count, count), M_phi;
  for (Eigen::Index first = 0; first < count; first += most) {
    const Eigen::Index width = std::min(most, count - first);
    problem.multiply_M(Phi.middleCols(first, width), M_phi);
    gram.middleCols(first, width) = transpose_times(Phi, M_phi);
  }
  if (problem.sum) problem.sum(gram.data(), gram.size());
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(count, count);
  const Eigen::MatrixXd inverse_root = Eigen::LLT<Eigen::MatrixXd>(gram).matrixU().solve(identity);
  for (Eigen::Index first = 0; first < Phi.rows(); first += kHeight) {
    const Eigen::Index height = std::min(kHeight, Phi.rows() - first);
    Phi.middleRows(first, height) = times(Phi.middleRows(first, height), inverse_root);
  }
}

void polish(const EigenProblem& problem, EigenPairs& pairs) {
  Eigen::MatrixXd R, M_Phi, difference;
  if (problem.project) problem.project(pairs.Phi);
  problem.multiply_K(pairs.Phi, R);
  problem.multiply_M(pairs.Phi, M_Phi);
  R -= M_Phi * pairs.omega2.asDiagonal();
  problem.project_residual(R);
  problem.solve(R, difference);
  pairs.Phi -= difference;
  orthonormalise(problem, pairs.Phi);
  measure_residuals(problem, pairs);
}

void polish_until_accurate(const EigenProblem& problem, double tolerance, EigenPairs& pairs) {
  constexpr int kMost = 6;
  double before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kMost && !is_accurate(pairs, tolerance); ++step) {
    const double worst = pairs.residual.maxCoeff();
    if (worst > 0.5 * before) return;
    before = worst;
    polish(problem, pairs);
    pairs.n_solves += static_cast<int>(pairs.Phi.cols());
    ++pairs.n_blocks;
  }
}

void measure_residuals(const EigenProblem& problem, EigenPairs& pairs) {
  const Eigen::Index count = pairs.Phi.cols();
  pairs.omega2.resize(count);
  pairs.residual.resize(count);
  pairs.round_off.resize(count);
  constexpr Eigen::Index kWidth = 16;  // columns at a time, to bound the memory
  for (Eigen::Index first = 0; first < count; first += kWidth) {
    const Eigen::Index width = std::min(kWidth, count - first);
    Eigen::MatrixXd K_phi, M_phi, magnitudes;
    problem.multiply_K(pairs.Phi.middleCols(first, width), K_phi);
    problem.multiply_M(pairs.Phi.middleCols(first, width), M_phi);
    if (problem.multiply_magnitudes)
      problem.multiply_magnitudes(pairs.Phi.middleCols(first, width), magnitudes);
    else
      magnitudes.setZero(problem.n, width);
    // Over all rows, wherever they are.
    const auto total = [&](Eigen::MatrixXd numbers) {
      if (problem.sum) problem.sum(numbers.data(), numbers.size());
      return numbers;
    };
    Eigen::MatrixXd energies(2, width);
    for (Eigen::Index c = 0; c < width; ++c)
      energies.col(c) << pairs.Phi.col(first + c).dot(K_phi.col(c)),
          pairs.Phi.col(first + c).dot(M_phi.col(c));
    energies = total(std::move(energies));
    Eigen::MatrixXd residual = K_phi;
    Eigen::MatrixXd scale = K_phi + problem.shift * M_phi;
    for (Eigen::Index c = 0; c < width; ++c) {
      pairs.omega2(first + c) = energies(0, c) / energies(1, c);
      residual.col(c) -= pairs.omega2(first + c) * M_phi.col(c);
    }
    problem.project_residual(residual);
    problem.project_residual(scale);
    Eigen::MatrixXd squares(3, width);
    squares << residual.colwise().squaredNorm(), magnitudes.colwise().squaredNorm(),
        scale.colwise().squaredNorm();
    squares = total(std::move(squares));
    for (Eigen::Index c = 0; c < width; ++c) {
      pairs.residual(first + c) = std::sqrt(squares(0, c) / squares(2, c));
      pairs.round_off(first + c) =
          std::numeric_limits<double>::epsilon() * std::sqrt(squares(1, c) / squares(2, c));
    }
  }
}

}  // namespace flexura::linalg
