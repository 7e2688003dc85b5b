// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/accuracy/scales.hpp"

namespace flexura::mbs {

/// Of the mechanism at the state s, at which it stands assembled.
Scales scales_of(const Mechanism& mechanism, const State& s);

}  // namespace flexura::mbs
