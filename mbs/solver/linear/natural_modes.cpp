// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "mbs/solver/linear/linearise.hpp"

namespace flexura::mbs {

namespace {

// Units of the coordinates, powers of 2, in which rows and columns of A are of one size: B. N. Parlett, C. Reinsch,
// Numer. Math. 13 (1969) 293.
Eigen::VectorXd balance(const Eigen::MatrixXd& A) {
  const Eigen::Index n = A.rows();
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(n);
  constexpr int kMostPasses = 100;
  bool changes = true;
  for (int pass = 0; pass < kMostPasses && changes; ++pass) {
    changes = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      double row = 0.0, column = 0.0;
      for (Eigen::Index j = 0; j < n; ++j)
        if (j != i) {
          row += std::abs(A(i, j)) * unit(j) / unit(i);
          column += std::abs(A(j, i)) * unit(i) / unit(j);
        }
      if (!(row > 0.0) || !(column > 0.0)) continue;
      const double factor = std::exp2(std::round(0.5 * std::log2(row / column)));
      if (column * factor + row / factor >= 0.95 * (row + column)) continue;
      unit(i) *= factor;
      changes = true;
    }
  }
  return unit;
}

// An eigenvector, x.  The QR algorithm leaves round-off of the largest entries of A in it: beside stiff modes a free rotation
// takes part by a multiple of the mode.  Elimination keeps small rows apart from large ones: one step of inverse iteration.
// `work` adds up flops, beyond a second of which x is left as it is.
Eigen::VectorXcd refined(const Eigen::MatrixXd& A, std::complex<double> value, const Eigen::VectorXcd& x,
                         double& work) {
  constexpr double kMostWork = 2e9, kBeside = 1e-9;
  const double n = static_cast<double>(A.rows());
  work += 8.0 / 3.0 * n * n * n;
  if (work > kMostWork || value.imag() == 0.0) return x;
  Eigen::MatrixXcd shifted = A.cast<std::complex<double>>();
  shifted.diagonal().array() -= value * (1.0 + kBeside);
  const Eigen::PartialPivLU<Eigen::MatrixXcd> lu(shifted);
  Eigen::VectorXcd y = x;
  for (int step = 0; step < 2; ++step) {
    y = lu.solve(y).eval();
    y.normalize();
  }
  return y.allFinite() ? y : x;
}

}  // namespace

std::vector<NaturalMode> natural_modes(const LinearSystem& system) {
  if (system.A.rows() == 0) return {};
  const Eigen::VectorXd unit = balance(system.A);
  const Eigen::MatrixXd A = unit.cwiseInverse().asDiagonal() * system.A * unit.asDiagonal();
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(A);
  // What rounding makes of the eigenvalues shows where A^T has others.
  const Eigen::VectorXcd again =
      Eigen::EigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(A.transpose()), false).eigenvalues();
  std::vector<NaturalMode> modes;
  double work = 0.0;
  for (Eigen::Index i = 0; i < system.A.rows(); ++i) {
    std::complex<double> value = solver.eigenvalues()(i);
    NaturalMode mode;
    mode.eigenvalue = value;
    constexpr double kOfSample = 10.0;
    mode.noise =
        kOfSample * (again.array() - value).abs().minCoeff() + system.relative_error * std::abs(value);
    if (std::abs(value.real()) <= mode.noise) mode.eigenvalue.real(0.0);
    // Of a pair that is two real ones to round-off both count.
    if (std::abs(value.imag()) <= mode.noise) mode.eigenvalue.imag(0.0);
    if (mode.eigenvalue.imag() < 0.0) continue;
    value = mode.eigenvalue;
    mode.frequency_hz = value.imag() / (2.0 * M_PI);
    mode.damping = std::abs(value) > 0.0 ? -value.real() / std::abs(value) : 0.0;
    mode.shape = system.Q.cast<std::complex<double>>() *
                 (unit.asDiagonal() * refined(A, value, solver.eigenvectors().col(i), work));
    Eigen::Index largest = 0;
    if (mode.shape.size() > 0 && mode.shape.cwiseAbs().maxCoeff(&largest) > 0.0)
      mode.shape /= mode.shape(largest);
    modes.push_back(std::move(mode));
  }
  // The slowest first, whether it vibrates or creeps: strongly damped modes do not come before the vibrations below them.
  std::ranges::stable_sort(modes, {}, [](const NaturalMode& mode) { return std::abs(mode.eigenvalue); });
  // Of a state that is left as fast as it is come back to, what decays before what grows.
  constexpr double kSame = 1e-9;
  for (std::size_t i = 1; i < modes.size(); ++i) {
    const std::complex<double> before = modes[i - 1].eigenvalue, after = modes[i].eigenvalue;
    if (std::abs(before + after) < kSame * std::abs(after) && before.real() > after.real())
      std::swap(modes[i - 1], modes[i]);
  }
  return modes;
}

std::vector<Eigen::MatrixXcd> frequency_response(const LinearSystem& system,
                                                 const Eigen::VectorXd& frequencies_hz) {
  std::vector<Eigen::MatrixXcd> out;
  // Balanced, so that stiff modes take no digits from the others.
  const Eigen::VectorXd unit = balance(system.A);
  const Eigen::MatrixXcd A = (unit.cwiseInverse().asDiagonal() * system.A * unit.asDiagonal())
                                 .cast<std::complex<double>>(),
                         B = (unit.cwiseInverse().asDiagonal() * system.B).cast<std::complex<double>>(),
                         C = (system.C * unit.asDiagonal()).cast<std::complex<double>>();
  for (const double f : frequencies_hz) {
    const std::complex<double> s(0.0, 2.0 * M_PI * f);
    Eigen::MatrixXcd dynamic = -A;
    dynamic.diagonal().array() += s;
    out.push_back(C * dynamic.partialPivLu().solve(B) + system.D.cast<std::complex<double>>());
    if (system.D_1.size() > 0) out.back() += s * system.D_1.cast<std::complex<double>>();
    if (system.D_2.size() > 0) out.back() += s * s * system.D_2.cast<std::complex<double>>();
  }
  return out;
}

Eigen::VectorXd with_resonances(const LinearSystem& system, const Eigen::VectorXd& grid) {
  std::vector<double> f(grid.begin(), grid.end());
  if (f.empty()) return grid;
  const double low = f.front(), high = f.back();
  for (const NaturalMode& mode : natural_modes(system)) {
    const double at = mode.frequency_hz, half_width = std::abs(mode.eigenvalue.real()) / (2.0 * M_PI);
    if (half_width > 0.5 * at) continue;  // no peak
    // Without damping it has no end: the points beside it show its foot.
    const double step = std::max(half_width, 1e-6 * at);
    for (const double k : {0.0, 0.5, 1.0, 2.0, 4.0, 8.0})
      for (const double side : {-1.0, 1.0})
        if (const double point = at + side * k * step;
            point > low && point < high && (k > 0.0 || half_width == step))
          f.push_back(point);
  }
  std::ranges::sort(f);
  const auto same = [](double a, double b) { return b - a <= 1e-12 * b; };
  f.erase(std::unique(f.begin(), f.end(), same), f.end());
  return Eigen::Map<const Eigen::VectorXd>(f.data(), static_cast<Eigen::Index>(f.size()));
}

}  // namespace flexura::mbs
