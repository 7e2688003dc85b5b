// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iosfwd>

#include "import/cad/joints/propose.hpp"

namespace flexura::import {

/// `flexura import --joints ask`: shows every proposed joint with its evidence and asks whether it is to be: yes, no, as another type,
/// all others as proposed, or nothing at all.  Throws std::invalid_argument where the answers end before the joints or
/// the user stops.
void ask_about_joints(const cad::Assembly& assembly, cad::Proposal& proposal,
                      const std::vector<std::string>& names, std::istream& in, std::ostream& out);

}  // namespace flexura::import
