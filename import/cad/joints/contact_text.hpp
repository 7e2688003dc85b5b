// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "import/cad/joints/propose.hpp"

namespace flexura::import::cad {

/// A pair that may touch, as one reads it and as a mechanism file has it.
struct ContactText {
  std::string says;  ///< "crank and yoke: 0.1 mm apart at ..."
  std::string
      lines;  ///< tables for the end of the mechanism file; empty where neither face is a plane, a sphere or a cylinder
};

/// A `surface_contact` between the two near faces: the flat or round one is touched by the nodes of the other. Stiffness and
/// damping are chosen. `name`: of the force and its marker.
ContactText contact_text(const Assembly& assembly, const std::vector<std::string>& names,
                         const ContactCandidate& candidate, const std::string& name);

}  // namespace flexura::import::cad
