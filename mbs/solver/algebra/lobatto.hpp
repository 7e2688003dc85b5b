// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

/// Lobatto's four points on [0, 1]: the ends and two between, exact to degree five.
namespace flexura::mbs::lobatto {

inline const double kNode[4] = {0.0, 0.5 - std::sqrt(0.05), 0.5 + std::sqrt(0.05), 1.0};

/// The cubic that is 1 at node i and 0 at the others.
double basis(int i, double x);
/// Its integral from 0 to x; at x = 1 Lobatto's weights.
double integral_of_basis(int i, double x);

}  // namespace flexura::mbs::lobatto
