// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "import/model/findings.hpp"
#include "import/model/mechanism.hpp"

namespace flexura::import::sdf {

struct Choices {
  bool floating = true;  ///< links that no joint holds float free, as in the file; otherwise they stand
  bool stops = true;     ///< limits become bump stops
  std::vector<std::string> packages = {};  ///< "NAME=FOLDER" for model://NAME/...
};

/// The models of an SDF as a mechanism: every link a body with the link's frame, every joint a joint along its axis (two with a massless body between
/// for the types with two axes), springs, dampers, friction and limits along them, gearboxes and mimics as couplers.
///
/// Throws Faults with all that leaves the motion open.
Mechanism to_mechanism(const std::filesystem::path& file, const Choices& choices, Findings& findings);

}  // namespace flexura::import::sdf
