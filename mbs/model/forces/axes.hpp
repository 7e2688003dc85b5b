// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/model/force.hpp"

namespace flexura::mbs {

/// The marker in whose axes the outputs of a force element give their components: the first one it acts
/// between, for applied forces the one that their `axes` names; -1: the world's.
int axes_of(const ForceElement& force);

}  // namespace flexura::mbs
