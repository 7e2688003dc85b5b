// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/system_difference.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of the accelerations that a step of the differences excites.
constexpr double kNoise = 1e-9;

int position_of(const LinearSystem& system, int coordinate) {
  const auto found = std::ranges::find(system.positions, coordinate);
  return found == system.positions.end() ? 0 : static_cast<int>(found - system.positions.begin());
}

}  // namespace

double largest_difference(const LinearSystem& at_0, const LinearSystem& at_tau, const MatrixXd& B,
                          const TypicalSizes& sizes, int& where) {
  const auto n_z = static_cast<int>(at_0.positions.size()), n_w = static_cast<int>(at_0.independent.size()),
             n_c = static_cast<int>(sizes.dynamic.size()), n_x = n_z + n_w + n_c;
  if (n_x == 0) return 0.0;
  // Positions that one of the two reads and the other does not.
  if (at_0.A.rows() != at_tau.A.rows() || at_0.positions.size() != at_tau.positions.size()) return 1.0;
  const MatrixXd BQ = B * at_0.Q, BV = B * at_0.V;
  MatrixXd X = MatrixXd::Identity(n_x, n_x);
  X.topRows(n_z) = BQ(at_tau.positions, Eigen::all);
  X.middleRows(n_z, n_w) = BV(at_tau.independent, Eigen::all);
  // The constraints leave the same directions free.
  const auto gap = [&](const MatrixXd& then, const MatrixXd& now) {
    const MatrixXd left = sizes.velocity.cwiseInverse().asDiagonal() * (then * X - now).leftCols(n_z);
    if (left.size() == 0) return 0.0;
    Eigen::Index row = 0, column = 0;
    const double open = left.cwiseAbs().maxCoeff(&row, &column);
    where = static_cast<int>(column);
    const double size = (sizes.velocity.cwiseInverse().asDiagonal() * now).cwiseAbs().maxCoeff();
    return open > kSameCoefficient * std::max(1.0, size) ? open : 0.0;
  };
  if (const double open = gap(at_tau.Q, BQ); open > 0.0) return open;
  const MatrixXd moved = X.partialPivLu().solve(at_tau.A * X);
  // Balanced: each row as large as its column (E. E. Osborne, J. ACM 7 (1960) 338-345).
  const MatrixXd sum = at_0.A.cwiseAbs().cwiseMax(moved.cwiseAbs());
  VectorXd typical(n_x);
  for (int k = 0; k < n_x; ++k)
    typical(k) = k < n_z         ? sizes.velocity(at_0.positions[k])
                 : k < n_z + n_w ? sizes.velocity(at_0.independent[k - n_z])
                                 : sizes.dynamic(k - n_z - n_w);
  VectorXd f = typical;
  for (int pass = 0; pass < 10; ++pass)
    for (int i = 0; i < n_x; ++i) {
      double row = 0.0, column = 0.0;
      for (int j = 0; j < n_x; ++j)
        if (j != i) {
          row = std::max(row, sum(i, j) * f(j) / f(i));
          column = std::max(column, sum(j, i) * f(i) / f(j));
        }
      if (row > 0.0 && column > 0.0) f(i) *= std::clamp(std::sqrt(row / column), 1e-3, 1e3);
    }
  const MatrixXd balanced = f.cwiseInverse().asDiagonal() * sum * f.asDiagonal();
  const MatrixXd change = f.cwiseInverse().asDiagonal() * (moved - at_0.A) * f.asDiagonal();
  const VectorXd row = balanced.rowwise().maxCoeff(), column = balanced.colwise().maxCoeff();
  // What the differences leave: a part of the accelerations that the step excites, and of those at hand.
  const VectorXd excited =
      (typical.cwiseInverse().asDiagonal() * sum * typical.asDiagonal()).colwise().maxCoeff().transpose();
  double largest = 0.0;
  for (int i = 0; i < n_x; ++i)
    for (int j = 0; j < n_x; ++j) {
      const double absolute = std::abs(moved(i, j) - at_0.A(i, j)) * typical(j) / typical(i);
      if (absolute <= kNoise * (sizes.acceleration + excited(j))) continue;
      const double relative = std::abs(change(i, j)) / std::sqrt(row(i) * column(j));
      if (relative > largest) {
        largest = relative;
        where = j < n_z ? j : j < n_z + n_w ? position_of(at_0, at_0.independent[j - n_z]) : j - n_w;
      }
    }
  // Inputs and outputs, each of its own size.
  const auto compare = [&](const MatrixXd& a, const MatrixXd& b, bool by_row) {
    for (Eigen::Index k = 0; k < (by_row ? a.rows() : a.cols()); ++k) {
      const VectorXd x = by_row ? VectorXd(a.row(k)) : VectorXd(a.col(k)),
                     y = by_row ? VectorXd(b.row(k)) : VectorXd(b.col(k));
      const double size = std::max(x.lpNorm<Eigen::Infinity>(), y.lpNorm<Eigen::Infinity>());
      if (size > 0.0) largest = std::max(largest, (x - y).lpNorm<Eigen::Infinity>() / size);
    }
  };
  if (at_0.B.cols() > 0) compare(at_0.B, X.partialPivLu().solve(at_tau.B), false);
  if (at_0.C.rows() > 0) compare(at_0.C, at_tau.C * X, true);
  return largest;
}

}  // namespace flexura::mbs
