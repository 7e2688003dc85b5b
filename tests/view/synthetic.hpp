// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/superelement/superelement.hpp"
#include "mbs/view/pages.hpp"

/// Bodies with known shapes for the pages' tests: pictures need no finite elements.
namespace flexura::view::synthetic {

constexpr double tube_length = 1.0;   // [m], along x from 0
constexpr double tube_radius = 0.06;  // [m]
constexpr double tube_bore = 0.04;    // [m]

/// Beam-like displacement of the tube's shape k >= 0 at a point of it, with sections plane and normal to the
/// axis:
///     k even: w(x) = sin((k/2 + 1) pi x / L) along y,   k odd: the same along z;   u_x = -w'(x) y (or z)
Eigen::Vector3d tube_displacement(int k, const Eigen::Vector3d& p);

/// An open tube with `around` x `along` quadrilaterals outside and inside, rings at both ends, edges on the
/// rings, an interface at each end and n_q shapes (tube_displacement); the 12 interface columns of `shapes`
/// are zero.
superelement::Superelement tube(int around, int along, int n_q);

/// Gives the tube stress modes: sigma_xx = E du_x/dx of each shape, all else zero, so that the von Mises
/// stress is its size: E w^2 |sin(w x) p_a|.
inline constexpr double tube_young = 2.1e11;
void add_stress(superelement::Superelement& tube);

/// Gives the tube the section forces of a slender beam at its ends, quarters and middle: with w the
/// deflection of a shape, M_z = EI w'', V_y = -M_z' (along y) or M_y = -EI w'', V_z = M_y' (along z).
inline constexpr double tube_bending_stiffness =
    tube_young * 0.785398163397448 *
    (tube_radius * tube_radius * tube_radius * tube_radius - tube_bore * tube_bore * tube_bore * tube_bore);
void add_sections(superelement::Superelement& tube);

/// The tube's modes as a page shows them: mode number k + 1 is shape k, at 100 (k/2 + 1)^2 Hz (z: one percent
/// more).
ModesPage tube_modes(const superelement::Superelement& se);

constexpr double crank_radius = 0.25;  // [m]
constexpr double engine_time = 2.0;    // [s], one turn of the crank each second
constexpr int engine_rows = 401;
constexpr int rod_modes = 4;

/// Crank angle 2 pi t about y; the crank pin at (r cos, 0, r sin), the slider pin on the x axis, distance
/// tube_length.
struct EnginePose {
  double crank, rod, slider;  ///< angle of crank and rod about -y [rad], place of the slider [m]
};
EnginePose engine_pose(double t);

/// Modal coordinate j of the rod [m]: 0.002 / (j + 1) sin(2 pi (2 + j) t).
double rod_modal(int j, double t);

/// A force on the slider, along the turning crank's x axis [N].
constexpr double push_force = 1000.0;

/// A slider-crank with a tube as its rod, two runs "rigid" and "flexible" of closed-form motion; `pictures`
/// gets the tube.
results::Results engine(Pictures& pictures);

}  // namespace flexura::view::synthetic
