// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "import/cad/contacts.hpp"

/// What comes near without being judged by what the faces are: by the corners of one part's triangles and the triangles of the other.
/// Right to the deviation of the triangles from the shape.
namespace flexura::import::cad {

/// How near the surfaces come to each other; `within` where they stay farther away than that.
double nearest(const PlacedPart& a, const PlacedPart& b, double within);

/// A place where faces come near each other.
struct Near {
  int face_a = 0, face_b = 0;  ///< numbers
  Contact contact;             ///< from A to B
  double distance = 0.0;
};

/// Where faces that are not paired with one another in `judged` come within `within` and look at each other.
std::vector<Near> unjudged(const PlacedPart& a, const PlacedPart& b, const std::vector<FacePair>& judged,
                           double within);

}  // namespace flexura::import::cad
