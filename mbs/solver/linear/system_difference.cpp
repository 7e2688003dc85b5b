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

int count_of(const LinearSystem& system) {
  return static_cast<int>(system.positions.size() + system.independent.size() + system.dynamic.size());
}

bool are_alike(const LinearSystem& a, const LinearSystem& b) {
  return a.A.rows() == b.A.rows() && a.positions.size() == b.positions.size();
}

// States of the first system in those of the later one.
MatrixXd brought(const LinearSystem& at_0, const LaterSystem& then) {
  const auto n_z = static_cast<int>(at_0.positions.size()), n_w = static_cast<int>(at_0.independent.size());
  MatrixXd X = MatrixXd::Identity(count_of(at_0), count_of(at_0));
  X.topRows(n_z) = (then.B * at_0.Q)(then.system.positions, Eigen::all);
  X.middleRows(n_z, n_w) = (then.B * at_0.V)(then.system.independent, Eigen::all);
  return X;
}

VectorXd typical_states(const LinearSystem& system, const TypicalSizes& sizes) {
  VectorXd typical(count_of(system));
  typical << sizes.velocity(system.positions), sizes.velocity(system.independent), sizes.dynamic;
  return typical;
}

}  // namespace

double largest_difference(const LinearSystem& at_0, const LaterSystem& then, const TypicalSizes& sizes,
                          int& where) {
  const auto n_z = static_cast<int>(at_0.positions.size()), n_w = static_cast<int>(at_0.independent.size()),
             n_x = count_of(at_0);
  if (n_x == 0) return 0.0;
  const LinearSystem& at_tau = then.system;
  // Positions that one of the two reads and the other does not.
  if (!are_alike(at_0, at_tau)) return 1.0;
  const MatrixXd BQ = then.B * at_0.Q, X = brought(at_0, then);
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
  const VectorXd typical = typical_states(at_0, sizes);
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
  return largest;
}

double largest_coupling_difference(const LinearSystem& at_0, const LaterSystem& at_once,
                                   const LaterSystem& then, const LaterSystem& soon_after,
                                   const TypicalSizes& sizes, std::string& where) {
  if (count_of(at_0) == 0) return 0.0;
  constexpr double kAbove = 10.0;  // round-off that is to count as a change
  const VectorXd typical = typical_states(at_0, sizes);
  // In coordinates of one size at the first instant: a column for each input, then for each output.
  std::vector<MatrixXd> couplings;
  const LaterSystem now{at_0, MatrixXd::Identity(then.B.rows(), then.B.cols())};
  for (const LaterSystem* one : {&now, &at_once, &then, &soon_after}) {
    if (!are_alike(at_0, one->system)) return 1.0;
    const MatrixXd X = brought(at_0, *one);
    couplings.emplace_back(X.rows(), at_0.B.cols() + at_0.C.rows());
    couplings.back() << typical.cwiseInverse().asDiagonal() * X.partialPivLu().solve(one->system.B),
        (one->system.C * X * typical.asDiagonal()).transpose();
  }
  double largest = 0.0;
  for (Eigen::Index k = 0; k < couplings[0].cols(); ++k) {
    const auto apart = [&](std::size_t a, std::size_t b) {
      return (couplings[a] - couplings[b]).col(k).lpNorm<Eigen::Infinity>();
    };
    const double change = apart(2, 0), size = std::max(couplings[0].col(k).lpNorm<Eigen::Infinity>(),
                                                       couplings[2].col(k).lpNorm<Eigen::Infinity>());
    if (change <= kAbove * std::max(apart(1, 0), apart(3, 2)) || change <= largest * size) continue;
    largest = change / size;
    const Eigen::Index output = k - at_0.B.cols();
    where = output < 0 ? at_0.inputs[static_cast<std::size_t>(k)]
                       : at_0.outputs[static_cast<std::size_t>(output)];
  }
  return largest;
}

}  // namespace flexura::mbs
