// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>

#include "import/cad/joints/contact_text.hpp"
#include "import/cad/joints/propose.hpp"
#include "import/model/folder.hpp"

namespace flexura::import::cad {

struct BuildOptions {
  ProposeOptions propose;
  bool joints = true;       ///< propose them; otherwise every body but ground floats free
  double density = 7850.0;  ///< of parts for which the file gives none [kg/m^3]
  /// Asked with the proposed joints and the names of the bodies: takes some away, changes others. Degrees of freedom are counted
  /// anew afterwards.
  std::function<void(const Assembly&, Proposal&, const std::vector<std::string>&)> decide = {};
};

/// A proposed joint as the mechanism has it.
struct NamedJoint {
  std::string name;
  std::size_t proposed = 0;  ///< index in Proposal::joints
  std::array<int, 2> on =
      {};  ///< number of the face of its first and its second body that carries its markers; 0: none
};

/// Two bodies that may touch.
struct NamedContact {
  int a = 0, b = 0;                   ///< instances
  Vector3d place = Vector3d::Zero();  ///< in the world
  ContactText text;
};

struct Built {
  Mechanism mechanism;
  std::vector<TextFile> texts;  ///< part files and their CAD files
  Proposal proposal;
  std::vector<NamedJoint> joints;      ///< in the order of the mechanism's elements
  std::vector<NamedContact> contacts;  ///< the nearest first
};

/// The assembly as a mechanism: a body for each instance in the frame of its part, a joint for each proposal, and for each
/// distinct part its exact shape (.brep) and a part file whose interfaces are the faces that joints sit on.
Built build(const Assembly& assembly, const std::string& name, const BuildOptions& options);

}  // namespace flexura::import::cad
