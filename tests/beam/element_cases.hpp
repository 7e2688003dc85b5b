// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <limits>

#include "beam/element/element.hpp"
#include "beam/section/shapes.hpp"
#include "tests/beam/common.hpp"

/// Sections, motions and measures that the element tests share.
namespace flexura::beam::testing {

inline constexpr double kEps = std::numeric_limits<double>::epsilon();

/// Largest difference relative to the diagonals, so that every unit has its own scale.
inline double scaled_difference(const Matrix12d& a, const Matrix12d& b) {
  double worst = 0.0;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j)
      worst = std::max(worst, std::abs(a(i, j) - b(i, j)) / std::sqrt(b(i, i) * b(j, j)));
  return worst;
}

/// A section that couples everything: an unsymmetrical composite.
inline Section coupled_section() {
  Matrix6d C = Matrix6d::Zero();
  C.diagonal() << 4e8, 6e7, 9e7, 3e5, 8e5, 5e5;
  const auto couple = [&](int i, int j, double r) { C(i, j) = C(j, i) = r * std::sqrt(C(i, i) * C(j, j)); };
  couple(N, T, 0.3);
  couple(N, M_y, 0.2);
  couple(N, M_z, -0.25);
  couple(V_y, V_z, 0.1);
  couple(V_y, T, -0.3);
  couple(V_z, T, 0.4);
  couple(V_z, M_y, 0.15);
  couple(V_y, M_z, 0.2);
  couple(T, M_y, -0.2);
  couple(M_y, M_z, 0.3);
  const SectionInertia inertia{20.0, 0.1, -0.2, 0.05, 0.08, 0.01};
  return matrix_section("composite", C, inertia.matrix());
}

inline Eigen::Matrix<double, 12, 6> rigid_motions(double length) {
  Eigen::Matrix<double, 12, 6> R = Eigen::Matrix<double, 12, 6>::Zero();
  R.topRows<6>().setIdentity();
  R.bottomRows<6>().setIdentity();
  R(8, 4) = -length;  // w = -x theta_y
  R(7, 5) = length;   // v = x theta_z
  return R;
}

}  // namespace flexura::beam::testing
