// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

/// Exact natural frequencies of a uniform beam bending in one plane (S. P. Timoshenko, Phil. Mag. 41 (1921)
/// 744-746 and 43 (1922) 125-131; T. C. Huang, J. Appl. Mech. 28 (1961) 579-584), found from the transfer
/// matrix of
///
///     w' = V/(G A_s) - beta,   beta' = M/(E I),   M' = V - rho I omega^2 beta,   V' = -rho A omega^2 w
///
/// G A_s infinite gives Rayleigh's beam, rho I = 0 as well Euler-Bernoulli's.  Nothing of Flexura is used
/// here.
namespace exact {

struct Beam {
  double length = 1.0, EI = 1.0, rho_A = 1.0;
  double rho_I = 0.0;
  double shear_flexibility = 0.0;  ///< 1 / (G A_s)
};

enum class End { free, pinned, clamped };

/// The first `count` circular frequencies above zero [rad/s].
std::vector<double> bending_frequencies(const Beam& beam, End left, End right, int count);

/// Pinned-pinned beam in closed form: the root of both branches of the frequency equation for n half waves.
struct PinnedPair {
  double first, second;
};
PinnedPair pinned_frequencies(const Beam& beam, int n);

}  // namespace exact
