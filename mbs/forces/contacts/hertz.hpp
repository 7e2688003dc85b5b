// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Contact of two curved elastic bodies after H. Hertz, J. reine angew. Math. 92 (1882) 156-171, in the form of
/// T. A. Harris and M. N. Kotzalas, Essential Concepts of Bearing Technology, CRC 2007, chapter 6.
///
/// With the sum Sigma of the four principal curvatures, and F the difference of their sums in the two principal planes over
/// Sigma, the semi-axes of the ellipse of contact have the ratio kappa >= 1 that solves
///
///     F = ((kappa^2 + 1) E - 2 K) / ((kappa^2 - 1) E),     K, E complete elliptic integrals of modulus sqrt(1 - kappa^-2)
///
/// and the bodies approach each other by delta = delta_star (3 Q / (Sigma E'))^(2/3) Sigma / 2, where
/// 1 / E' = ((1 - nu_1^2) / E_1 + (1 - nu_2^2) / E_2) / 2 and delta_star = (2 K / pi) (pi / (2 kappa^2 E))^(1/3).
namespace flexura::mbs::hertz {

/// kappa of the curvature difference 0 <= F < 1.  Throws std::invalid_argument outside.
double axis_ratio(double curvature_difference);
/// delta_star.
double approach_factor(double curvature_difference);
/// k of Q = k delta^(3/2) [N m^-3/2]; `modulus` is E' [Pa], `curvature_sum` [1/m].
double point_stiffness(double curvature_sum, double curvature_difference, double modulus);

}  // namespace flexura::mbs::hertz
