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

}  // namespace flexura::mbs::test
