// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

namespace flexura::mbs {

/// What a linear system about `s` leaves out of what switches, a sentence for each: kinks and jumps at which the state itself
/// stands (a spring of two stiffnesses at rest, a stop that is just touched), on one side of which alone the system holds;
/// and controls that keep their value between their switches (sample and hold, relays) although they watch the motion, so
/// that a loop which they close is open in it.
std::vector<std::string> notes_on_switches(const Mechanism& mechanism, const State& s);

}  // namespace flexura::mbs
