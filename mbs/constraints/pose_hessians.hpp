// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

#include "mbs/base/math/spatial.hpp"

namespace flexura::mbs {

/// H_k(b, a) of n <= 6 functions y_k of the pose of M in F: along xi their gradients G_k (6, by the motion of M in F, seen
/// from F) change by H_k xi.  What is quadratic in the motion in y_k'' is gamma_k(V) = H_k(V, V), so that its polarisation is
/// the symmetric part of H_k; the other is half of G_k (w x theta, 0), since turning about theta and about w do not commute:
/// H(xi, V) - H(V, xi) = G (w x theta, 0).
///
/// `gamma(V)` returns the n values as a vector; `gradient(k)`, asked after it, G_k (6).
template <class Gamma, class Gradient>
std::array<Matrix6d, 6> pose_hessians(const Gamma& gamma, const Gradient& gradient) {
  std::array<Matrix6d, 6> H;
  std::size_t n = 0;
  for (int a = 0; a < 6; ++a) {
    const auto y = gamma(Vector6d::Unit(a));
    n = static_cast<std::size_t>(y.size());
    for (std::size_t k = 0; k < n; ++k) H[k](a, a) = y(static_cast<Eigen::Index>(k));
  }
  for (int a = 0; a < 6; ++a)
    for (int b = 0; b < a; ++b) {
      const auto y = gamma(Vector6d::Unit(a) + Vector6d::Unit(b));
      for (std::size_t k = 0; k < n; ++k)
        H[k](a, b) = H[k](b, a) = 0.5 * (y(static_cast<Eigen::Index>(k)) - H[k](a, a) - H[k](b, b));
    }
  // e_b . [-G]x e_a / 2 = G . (e_b x e_a) / 2.
  for (std::size_t k = 0; k < n; ++k)
    H[k].topLeftCorner<3, 3>() -= 0.5 * skew(gradient(static_cast<int>(k)).template head<3>());
  return H;
}

}  // namespace flexura::mbs
