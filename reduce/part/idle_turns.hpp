// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "reduce/assembly/input/part.hpp"

/// Rotations of nodes that nothing holds and nothing follows: behind a pin flag.  K is
/// singular in them (what other programs call AUTOSPC takes them out).  Each gets a spring to the turn of an element beside it,
///
///     v . theta_n - v . e x (u_m - u_n) / l      across the element (e, l: direction and length from n to m),
///     v . theta_n - v . theta_m                  along it,
///
/// which rigid motions do not strain, and which is never strained: theta_n is free to follow, as nothing else holds it.  So the
/// spring's stiffness does not matter.
namespace flexura::reduce {

/// Once all elements, masses and interfaces are there.  Throws std::invalid_argument where an interface retains such a rotation.
void hold_idle_turns(Part& part, std::vector<std::string>& warnings);

}  // namespace flexura::reduce
