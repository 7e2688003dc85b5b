// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "beam/element/element.hpp"

/// What the axial force of an element works on when it bends and twists: the terms of its geometric stiffness.
namespace flexura::beam {

/// (v', w', theta_x') at a place of an element from the displacements of its ends, in its axes.
struct SlopeStation {
  double x, weight;
  Eigen::Matrix<double, 3, 12> slopes;
};
/// Four Gauss points from end 1 up to `to`: exact for slopes of degree two and N of degree three.
std::array<SlopeStation, 4> slope_stations(const Element& element, double to);

/// Force and moment at x [N, N m], in the axes of B, of the inertia forces of a piece with mass m [kg] and first and second
/// moments s = int r dm, E = int r r^T dm about x, for the unit motions of B of the stiffening terms: accelerations along
/// x, y, z, angular accelerations about them, then omega_a omega_b, (a, b) = xx, yy, zz, xy, yz, zx.
using InertiaLoads = Eigen::Matrix<double, 6, 12>;
InertiaLoads inertia_loads(const Eigen::Vector3d& x, double m, const Eigen::Vector3d& s,
                           const Eigen::Matrix3d& E);
/// The same per length of an element, x from its end 1, in its axes.
InertiaLoads line_loads(const Placement& placement, double x, const SectionInertia& section);

}  // namespace flexura::beam
