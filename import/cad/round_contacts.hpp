// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/cad/contacts.hpp"

/// Round faces on one axis: a shaft in a bore, a cone in its seat. True where they touch; then `pair` has all but its faces.
namespace flexura::import::cad {

bool cylinders_touch(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                     double clearance, FacePair& pair);
bool cones_touch(const PlacedPart& a, const PlacedFace& fa, const PlacedPart& b, const PlacedFace& fb,
                 double clearance, FacePair& pair);

}  // namespace flexura::import::cad
