// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "import/cad/contacts.hpp"

/// What faces say about how two parts are joined, and how it is told.
namespace flexura::import::cad {

/// "0.2 mm" of metres.
std::string mm(double x);

/// One line about a pair of faces of the parts called a and b.
std::string evidence_of(const FacePair& pair, const std::string& a, const std::string& b);

/// Every face turns into itself about the axis; small ones of no known kind (fillets) may be anything.
bool is_of_revolution(const PlacedPart& part, const Vector3d& point, const Vector3d& axis, double clearance);

}  // namespace flexura::import::cad
