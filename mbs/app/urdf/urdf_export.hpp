// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

namespace flexura::app {

/// A mechanism as a robot description.
struct Urdf {
  std::string text;
  /// Surfaces of bodies with a superelement, as STL files beside it: name, content.
  std::vector<std::pair<std::filesystem::path, std::string>> meshes;
  std::vector<std::string> notes;  ///< what a URDF has no words for and was left out
};

/// Every body a link whose frame is that of the joint that leads to it, ground the link "world"; joints of one freedom as they are, of
/// several as a chain of them with links without inertia between, where turning and sliding one after the other is what the joint does.
/// `meshes` is the folder of the surfaces as the URDF names it.  Throws std::invalid_argument with one sentence where it cannot be
/// one: loops, constraints, joints that are no such chain.
Urdf to_urdf(const mbs::Mechanism& mechanism, const std::string& meshes);

}  // namespace flexura::app
