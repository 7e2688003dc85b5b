// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/elements/material.hpp"

/// What the thickness of a shell gives: stiffness and mass per area.
namespace flexura::reduce {

/// In-plane forces and moments N = A e + B k, M = B e + D k of the strains e and curvatures k (11, 22, 12) of the middle
/// surface, transverse forces Q = S gamma (13, 23), and stresses of the outermost layers, sigma = top (e + z k).
///
/// S is 5/6 of the shear moduli where the section is of one material.  Of layers it has the energy of the shear stresses that
/// go with bending in each of the section's two axes, N = 0:
///
///     tau(z) = -int (Q (e + z k)) dz  for a moment of 1,   S^-1 = int tau^T G^-1 tau dz
struct ShellSection {
  Eigen::Matrix3d A, B, D;
  Eigen::Matrix2d S;
  Eigen::Matrix3d top, bottom;  ///< top: on the side of the normal
  bool coupled = false;         ///< B is not zero
};

/// Of a thickness t [m] in axes R (columns e_1, e_2 and the normal).  Layers fill t, whatever the sum of theirs.
ShellSection shell_section(const Material& material, double t, const Eigen::Matrix3d& R);

/// Per area, about the middle surface along the normal: int rho z^k dz, k = 0, 1, 2.
struct ShellMass {
  double mass = 0.0, first = 0.0, second = 0.0;
};
ShellMass shell_mass_per_area(const Material& material, double t);

}  // namespace flexura::reduce
