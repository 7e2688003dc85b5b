// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "reduce/linalg/eigen/spectrum_slices.hpp"

namespace flexura::linalg {

int slice_vectors(int modes, int block, double room) {
  const int most = 3 * modes + 17 * block, least = std::min(most, modes + modes / 3 + 6 * block);
  return static_cast<int>(std::clamp(room, static_cast<double>(least), static_cast<double>(most)));
}

double growth_of_number(const Eigen::VectorXd& omega2) {
  const Eigen::Index n = omega2.size(), half = n / 2;
  const double base = n > 0 ? std::min(omega2(0), 0.0) : 0.0;
  if (n < 8) return 1.5;
  const double upper = omega2(n - 1) - base, lower = omega2(half) - base;
  if (!(upper > lower) || !(lower > 0.0)) return 1.5;
  return std::clamp(
      std::log(static_cast<double>(n) / static_cast<double>(half + 1)) / std::log(upper / lower), 0.3, 4.0);
}

double expected_below(const Eigen::VectorXd& omega2, double limit) {
  const Eigen::Index n = omega2.size();
  if (n == 0 || !(limit > omega2(n - 1))) return static_cast<double>((omega2.array() < limit).count());
  const double base = std::min(omega2(0), 0.0);
  return static_cast<double>(n) * std::pow((limit - base) / (omega2(n - 1) - base), growth_of_number(omega2));
}

namespace {

// Of block Lanczos with so many vectors, in operations of solves: orthogonalisation is two passes along the basis and what is
// beside them, in products that run three times as fast; looks at the projected matrix.
double lanczos_operations(const EigenProblem& problem, double n_rows, double vectors) {
  return vectors * problem.solve_operations + 1.8 * n_rows * vectors * vectors + 10.0 * std::pow(vectors, 3);
}

}  // namespace

// The numbers are those of a solid part of 59,283 unknowns (tests/benchmarks/README.md): vectors that it took, processor time.
int modes_per_slice(const EigenProblem& problem, double n_rows, int count, int block) {
  constexpr int kFewest = 200;  // less is a matter of seconds either way
  if (!problem.shifted || count < kFewest || !(problem.factor_operations > 0.0)) return 0;
  const double k = count, b = block;
  const double one_basis = lanczos_operations(problem, n_rows, 2.4 * k + 20.0 * block_lanczos_width(count));
  double least = 0.85 * one_basis;
  int best = 0;
  for (int modes = 4 * block; modes <= count; modes += block) {
    const double shifts = std::ceil(k / modes);
    // A factor is made faster than it is read by solves, but K - sigma M must be added up and analysed; and the vectors of
    // each slice are taken out of those of all others.
    const double all = shifts * (0.65 * problem.factor_operations + 6e5 * n_rows) +
                       (shifts + 1.0) * lanczos_operations(problem, n_rows, 2.0 * modes + 10.0 * b) +
                       n_rows * k * k;
    if (all < least) {
      least = all;
      best = modes;
    }
  }
  return best;
}

}  // namespace flexura::linalg
