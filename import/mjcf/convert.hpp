// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "import/model/findings.hpp"
#include "import/model/mechanism.hpp"

namespace flexura::import::mjcf {

struct Choices {
  bool stops = true;  ///< limits become bump stops
};

/// An MJCF file as a mechanism: every body with its frame, a joint for each of its joints (massless bodies between those of one body) whose coordinate
/// is MuJoCo's qpos, and springs, dampers, armatures, limits, actuators, tendons, equalities and keyframes as far as the mechanism
/// file has them; notes say what it has not.
///
/// Throws Faults with all that leaves the motion open: masses that are not known, names that
/// mean nothing, bodies that deform.
Mechanism to_mechanism(const std::filesystem::path& file, const Choices& choices, Findings& findings);

}  // namespace flexura::import::mjcf
