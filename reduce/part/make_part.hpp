// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "reduce/part/part_mesh.hpp"

/// From a part file and its mesh to the model that is reduced: interfaces, masses, links, loads.
namespace flexura::reduce {

struct ModelledPart {
  Part part;
  int n_interfaces = 0;  ///< the first ones; after them come ties of the deck that are no interfaces
  std::vector<LoadField> loads;
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
};

/// Throws input::InputError naming the table.
ModelledPart make_part(const PartInput& input, PartMesh&& from);

}  // namespace flexura::reduce
