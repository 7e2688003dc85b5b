// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <random>

namespace flexura::linalg {

/// Normally distributed numbers of variance 1 (G. E. P. Box, M. E. Muller, Ann. Math. Stat. 29 (1958), 610): the standard
/// library's take several times as long, for they ask for logarithms of long doubles.
inline Eigen::MatrixXd random_numbers(Eigen::Index rows, Eigen::Index cols, std::mt19937_64& random) {
  const auto uniform = [&random] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  Eigen::MatrixXd X(rows, cols);
  double* numbers = X.data();
  for (Eigen::Index k = 0; k < X.size(); k += 2) {
    const double radius = std::sqrt(-2.0 * std::log(uniform())), angle = 2.0 * std::numbers::pi * uniform();
    numbers[k] = radius * std::cos(angle);
    if (k + 1 < X.size()) numbers[k + 1] = radius * std::sin(angle);
  }
  return X;
}

}  // namespace flexura::linalg
