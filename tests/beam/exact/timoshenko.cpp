// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/beam/exact/timoshenko.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace exact {
namespace {

using Real = long double;  // the determinant cancels by exp(beta L): 1e7 for the sixth mode
using Matrix = std::array<std::array<Real, 4>, 4>;

Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k) c[i][j] += a[i][k] * b[k][j];
  return c;
}

// exp(A): A halved until small, Taylor, squared back.
Matrix exponential(Matrix a) {
  Real size = 0;
  for (const auto& row : a)
    for (const Real x : row) size = std::max(size, std::abs(x));
  int halvings = 0;
  for (; size > Real(0.05); size /= 2) ++halvings;
  for (auto& row : a)
    for (Real& x : row) x = std::ldexp(x, -halvings);
  Matrix sum{}, term{};
  for (int i = 0; i < 4; ++i) sum[i][i] = term[i][i] = 1;
  for (int n = 1; n < 18; ++n) {
    term = multiply(term, a);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        term[i][j] /= n;
        sum[i][j] += term[i][j];
      }
  }
  for (; halvings > 0; --halvings) sum = multiply(sum, sum);
  return sum;
}

// State (w/L, beta, M L/EI, V L^2/EI); which two vanish at an end.
std::array<int, 2> zero_states(End end) {
  if (end == End::free) return {2, 3};
  if (end == End::pinned) return {0, 2};
  return {0, 1};
}

Real determinant(const Beam& beam, End left, End right, Real omega) {
  const Real L = beam.length, EI = beam.EI, w2 = omega * omega;
  Matrix a{};
  a[0][3] = EI * beam.shear_flexibility / (L * L);
  a[0][1] = -1;
  a[1][2] = 1;
  a[2][3] = 1;
  a[2][1] = -beam.rho_I * w2 * L * L / EI;
  a[3][0] = -beam.rho_A * w2 * L * L * L * L / EI;
  const Matrix transfer = exponential(a);
  const auto zero = zero_states(left), wanted = zero_states(right);
  std::array<int, 2> open{};
  for (int i = 0, k = 0; i < 4; ++i)
    if (i != zero[0] && i != zero[1]) open[k++] = i;
  return transfer[wanted[0]][open[0]] * transfer[wanted[1]][open[1]] -
         transfer[wanted[0]][open[1]] * transfer[wanted[1]][open[0]];
}

}  // namespace

std::vector<double> bending_frequencies(const Beam& beam, End left, End right, int count) {
  std::vector<double> roots;
  // Steps well below the smallest spacing that occurs: a hundredth of the first pinned Euler-Bernoulli
  // frequency.
  const Real step =
      std::pow(std::numbers::pi_v<Real> / beam.length, 2) * std::sqrt(beam.EI / beam.rho_A) / 100;
  Real low = step / 10, f_low = determinant(beam, left, right, low);
  while (static_cast<int>(roots.size()) < count) {
    const Real high = low + step, f_high = determinant(beam, left, right, high);
    if ((f_low < 0) != (f_high < 0)) {
      Real a = low, b = high;
      for (int k = 0; k < 70; ++k) {
        const Real middle = (a + b) / 2;
        ((determinant(beam, left, right, middle) < 0) == (f_low < 0) ? a : b) = middle;
      }
      roots.push_back(static_cast<double>((a + b) / 2));
    }
    low = high;
    f_low = f_high;
  }
  return roots;
}

PinnedPair pinned_frequencies(const Beam& beam, int n) {
  // rho I rho A/(G A_s) w^4 - [rho A + rho I q^2 + rho A EI q^2/(G A_s)] w^2 + EI q^4 = 0
  const double q2 = std::pow(n * std::numbers::pi / beam.length, 2);
  const double a = beam.rho_I * beam.rho_A * beam.shear_flexibility;
  const double b = beam.rho_A + beam.rho_I * q2 + beam.rho_A * beam.EI * q2 * beam.shear_flexibility;
  const double c = beam.EI * q2 * q2;
  const double root = b + std::sqrt(b * b - 4 * a * c);
  return {std::sqrt(2 * c / root), a > 0 ? std::sqrt(root / (2 * a)) : INFINITY};
}

}  // namespace exact
