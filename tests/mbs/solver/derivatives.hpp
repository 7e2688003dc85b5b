// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/mechanism.hpp"

/// The derivatives that Newton's method and the linearisation use, against central differences of fourth
/// order.
namespace flexura::mbs::checks {

/// What a derivative that comes from differences itself may err by: 4e-11 of a scale that may be some ten
/// times that of the sum.
inline constexpr double kByDifferences = 1e-9;

/// At two random states, with everything and with what Newton's method needs.  Beside the error of the
/// differences here, a derivative may err by `own_error` of the scale, where it comes from differences
/// itself.
void derivatives_agree(const Mechanism& mechanism, double own_error = 0.0);

}  // namespace flexura::mbs::checks
