// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "import/cad/contacts.hpp"

/// Threads, as CAD files have them: flanks that are screws (slippage.hpp); a bolt of the nominal diameter in a hole of the
/// tap drill's, which overlap; or nothing but a name.
namespace flexura::import::cad {

/// What a name says: "M8", "M12x1.5", "Tr16x4", "lead screw".
struct NamedThread {
  double diameter = 0.0, lead = 0.0;  ///< [m]; 0: not said
  bool drives = false;  ///< its word is of a thread that moves something: spindle, lead screw, Tr
};
std::optional<NamedThread> thread_named(const std::string& name);

/// The lead of a thread of one start: ISO 261 coarse of the nearest diameter.
double coarse_lead(double diameter);

/// Pairs of faces of A and B on one axis that screw into one another by their flanks or as a thread drawn by cylinders that overlap.
/// One pair for each axis.
std::vector<FacePair> find_threads(const PlacedPart& a, const PlacedPart& b, const std::string& name_a,
                                   const std::string& name_b, double clearance);

/// Contacts of a screw: across the axis, and along its flanks to both sides.
std::vector<Contact> screw_contacts(const FacePair& pair);

}  // namespace flexura::import::cad
