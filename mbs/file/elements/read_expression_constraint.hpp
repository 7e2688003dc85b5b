// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/file/elements/element_types.hpp"

namespace flexura::mbs {

/// The constraint that a formula of the motion vanishes.
ConstraintType expression_constraint();

}  // namespace flexura::mbs
