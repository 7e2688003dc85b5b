// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/formulas/space_curve.hpp"

namespace flexura::mbs {

/// The keys `points` and `closed` of a curve in space, and their reader.  Throws InputError.
std::vector<input::Key> space_curve_keys();
SpaceCurve read_space_curve(const input::Section& section);

}  // namespace flexura::mbs
