// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/spectrum.hpp"

#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace flexura::study {

double reach(const Eigen::MatrixXd& y, double h, double share) {
  const Eigen::Index n = y.rows();
  if (n < 4 || !(h > 0.0)) return 0.0;
  Eigen::VectorXd window(n);
  for (Eigen::Index i = 0; i < n; ++i)
    window(i) =
        0.5 *
        (1.0 - std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n)));
  // Zeros behind the rows make their number one of the fast transformation's, which takes n^2 for a prime one.
  const auto padded = static_cast<Eigen::Index>(std::bit_ceil(static_cast<std::size_t>(n)));
  Eigen::VectorXd power = Eigen::VectorXd::Zero(padded / 2 + 1);
  Eigen::VectorXd column = Eigen::VectorXd::Zero(padded);
  Eigen::FFT<double> fft;
  for (Eigen::Index k = 0; k < y.cols(); ++k) {
    column.head(n) = (y.col(k).array() - y.col(k).mean()) * window.array();
    Eigen::VectorXcd line;
    fft.fwd(line, column);
    power += line.head(power.size()).cwiseAbs2();
  }
  const double whole = power.sum();
  double sum = 0.0;
  for (Eigen::Index i = 0; i < power.size(); ++i) {
    sum += power(i);
    if (sum >= share * whole) return static_cast<double>(i) / (static_cast<double>(padded) * h);
  }
  return 0.5 / h;
}

}  // namespace flexura::study
