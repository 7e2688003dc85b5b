// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "beam/section/shapes.hpp"

namespace flexura::beam {

/// (sigma_xx, tau_xy, tau_xz) = S (N, V_y, V_z, T, M_y, M_z) at a place on the outline of a standard section, 3 x 6 [1/m^2, 1/m^3]:
///   stretch and bending   exact
///   torsion               exact for circles, ellipses (hollow ones with similar inner contour) and rectangles: Saint-Venant's series
///                         (S. Timoshenko, J. N. Goodier, Theory of Elasticity, art. 109); other hollow ellipses and hollow
///                         rectangles by Bredt's shear flow and the open part, zero at corners: thin walls
///   shear forces          Jourawski's V Q / (I b): on the sides of boxes along them, in hollow boxes also on those across them; on
///                         ellipses along the contour, by a cut on the ray from the middle
/// `y`, `z`: from the centroid, on the outer or an inner contour.
Eigen::Matrix<double, 3, 6> stress_on_outline(const Shape& shape, const Constants& constants, double y,
                                              double z);

}  // namespace flexura::beam
