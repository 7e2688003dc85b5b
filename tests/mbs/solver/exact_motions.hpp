// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

/// Motions known in closed form, as mechanism files with the values of their outputs.  SI units, world axes.
namespace flexura::mbs::test {

struct ExactMotion {
  std::string text;                                  ///< the mechanism's file
  std::function<Eigen::VectorXd(double t)> outputs;  ///< of the file's quantities, in their order
};

/// Without loads, a mass `a` of 1 kg on a slide `j`; keys of the slide may follow.
std::string slide();

/// x'' + 2 zeta w x' + w^2 x = 0, 0 <= zeta < 1, from x0, v0: position and speed.
ExactMotion damped_oscillator(double w, double zeta, double x0, double v0);

/// A body without loads of the moments J, J, J_e about its axes, turned by the rotation vector `turn` at its start, with the angular
/// velocity w, which goes round the angular momentum L at |L| / J (L. D. Landau, E. M. Lifshitz, Mechanics, section 33): angular
/// velocity, 3.
ExactMotion free_top(double J, double J_e, const Eigen::Vector3d& w, const Eigen::Vector3d& turn);

/// Index 2 (with generalised_alpha index 3): a mass m on a thread of length r goes round at w: x, y and the tension m w^2 r.
ExactMotion sling(double m, double r, double w);

/// A mass of 1 kg stands on a spring of w^2 and a damper of 2 zeta w, 0 <= zeta < 1, on a ground that moves by A sin(W t), under gravity g
/// = 9.81 m/s^2, and starts at y0 from where the spring is relaxed, at rest beside the ground: y'' + 2 zeta w y' + w^2 y = A W^2 sin(W t) -
/// g.  The force of spring and damper, -w^2 y - 2 zeta w y'.  A pendulum of 0.3 m swings beside it and, with `cart`, a mass
/// on a soft spring: of both nothing is stored.
struct ShakenSpring {
  double w = 1.0, zeta = 0.0, y0 = 0.0, A = 0.0, W = 1.0;
  bool cart = false;
};
ExactMotion shaken_spring(const ShakenSpring& spring);

}  // namespace flexura::mbs::test
