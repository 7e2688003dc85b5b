// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/file/elements/element_types.hpp"

namespace flexura::mbs {

/// The measure of what an element exerts.  It names joints, drives, constraints or forces: read it after all of these.
MeasureType reaction_type();

}  // namespace flexura::mbs
