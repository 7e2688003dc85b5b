// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/shell_cell.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "reduce/elements/material.hpp"

namespace flexura::reduce::shell {

PlaneStress plane_stress(const Matrix6& D, const Matrix3d& R) {
  const Matrix6 local = turned({.name = {}, .D = D, .density = 1.0}, R.transpose()).D;
  constexpr std::array<int, 3> in_plane = {0, 1, 3};
  constexpr std::array<int, 2> across = {5, 4};  // 13 and 23
  PlaneStress out;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      out.D(a, b) =
          local(in_plane[a], in_plane[b]) - local(in_plane[a], 2) * local(2, in_plane[b]) / local(2, 2);
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b) out.shear(a, b) = 5.0 / 6.0 * local(across[a], across[b]);
  return out;
}

Functions functions_at(Index n, double r, double s) {
  Functions f;
  f.N.resize(n), f.P.resize(n), f.dN.resize(n, 2), f.dP.resize(n, 2);
  if (n == 3) {
    f.N << 1.0 - r - s, r, s;
    f.dN << -1, -1, 1, 0, 0, 1;
    for (int k = 0; k < 3; ++k) {
      const int j = (k + 1) % 3;
      f.P(k) = 4.0 * f.N(k) * f.N(j);
      f.dP.row(k) = 4.0 * (f.N(k) * f.dN.row(j) + f.N(j) * f.dN.row(k));
    }
    return f;
  }
  f.N << 0.25 * (1 - r) * (1 - s), 0.25 * (1 + r) * (1 - s),  //
      0.25 * (1 + r) * (1 + s), 0.25 * (1 - r) * (1 + s);
  f.dN << -0.25 * (1 - s), -0.25 * (1 - r), 0.25 * (1 - s), -0.25 * (1 + r), 0.25 * (1 + s), 0.25 * (1 + r),
      -0.25 * (1 + s), 0.25 * (1 - r);
  f.P << 0.5 * (1 - r * r) * (1 - s), 0.5 * (1 + r) * (1 - s * s), 0.5 * (1 - r * r) * (1 + s),
      0.5 * (1 - r) * (1 - s * s);
  f.dP << -r * (1 - s), -0.5 * (1 - r * r), 0.5 * (1 - s * s), -s * (1 + r), -r * (1 + s), 0.5 * (1 - r * r),
      -0.5 * (1 - s * s), -s * (1 - r);
  f.dM.resize(2, 2);
  f.dM << -2 * r, 0, 0, -2 * s;
  return f;
}

std::vector<Place> quadrature(Index n) {
  if (n == 3) return {{0.5, 0.0, 1.0 / 6.0}, {0.5, 0.5, 1.0 / 6.0}, {0.0, 0.5, 1.0 / 6.0}};
  const double g = 1.0 / std::sqrt(3.0);
  return {{-g, -g, 1.0}, {g, -g, 1.0}, {g, g, 1.0}, {-g, g, 1.0}};
}

Jacobian jacobian(const Functions& f, const Corners& x) {
  const Matrix2d dx_dr = x.transpose() * f.dN;  // (a, b) = dx_a/dr_b
  return {dx_dr.determinant(), dx_dr.inverse()};
}

}  // namespace flexura::reduce::shell
