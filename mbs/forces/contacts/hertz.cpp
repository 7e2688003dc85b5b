// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/forces/contacts/hertz.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace flexura::mbs::hertz {
namespace {

// F of kappa; it rises from 0 at 1 to 1 at infinity.
double difference_of(double kappa) {
  const double modulus = std::sqrt(1.0 - 1.0 / (kappa * kappa));
  const double K = std::comp_ellint_1(modulus), E = std::comp_ellint_2(modulus);
  return ((kappa * kappa + 1.0) * E - 2.0 * K) / ((kappa * kappa - 1.0) * E);
}

}  // namespace

double axis_ratio(double curvature_difference) {
  if (!(curvature_difference >= 0.0 && curvature_difference < 1.0))
    throw std::invalid_argument(
        "the difference of curvatures of a point contact lies between 0 and 1 (excluded)");
  // Below, the difference of nearly equal integrals is round-off: kappa - 1 = 4 F / 3.
  if (curvature_difference < 1e-5) return 1.0 + 4.0 / 3.0 * curvature_difference;
  double low = 0.0, high = 1.0;  // of ln kappa
  while (difference_of(std::exp(high)) < curvature_difference) high *= 2.0;
  for (int i = 0; i < 200 && high - low > 1e-15 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (difference_of(std::exp(middle)) < curvature_difference ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

double approach_factor(double curvature_difference) {
  const double kappa = axis_ratio(curvature_difference), modulus = std::sqrt(1.0 - 1.0 / (kappa * kappa));
  return 2.0 * std::comp_ellint_1(modulus) / std::numbers::pi *
         std::cbrt(std::numbers::pi / (2.0 * kappa * kappa * std::comp_ellint_2(modulus)));
}

double point_stiffness(double curvature_sum, double curvature_difference, double modulus) {
  const double factor = approach_factor(curvature_difference);
  return curvature_sum * modulus / 3.0 * std::pow(2.0 / (factor * curvature_sum), 1.5);
}

}  // namespace flexura::mbs::hertz
