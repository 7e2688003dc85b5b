// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/superelement/superelement.hpp"

/// A straight Euler-Bernoulli beam along x from Bo, as a superelement with interfaces "root" (at Bo) and
/// "tip", and "p1", "p2", ... at equal distances between: the element matrices of beam/, reduced here with dense matrices and all fixed-interface modes, so
/// that it deforms as the finite-element model does.
namespace flexura::mbs::beams {

struct StraightBeam {
  double length = 1.0;
  int elements = 16;
  int between = 0;  ///< interfaces between root and tip; elements are a multiple of between + 1
  double EA = 1.0, GI_t = 1.0, EI_y = 1.0, EI_z = 1.0;  ///< [N], [N m^2]
  double mass_per_length = 1.0;                         ///< [kg/m]
  double rho_I_y = 1e-8, rho_I_z = 1e-8;                ///< int z^2 dm, int y^2 dm [kg m]
};

/// With geometric stiffening for every load that puts an axial force into the beam, held at the root:
///
///     K_G = int N(x) (v'^2 + w'^2 + (I_p/A) theta_x'^2) dx,
///     N = -m (L - x) for unit a_x,  m (L^2 - x^2) / 2 for unit w_y^2 or w_z^2,  1 for a unit pull at the
///     tip.
///
/// Loads that bend the beam have no term: right for motions in which the beam carries no large moments.
superelement::Superelement beam_superelement(const StraightBeam& beam);

}  // namespace flexura::mbs::beams
