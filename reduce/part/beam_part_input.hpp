// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "beam/model/mesh.hpp"
#include "reduce/beams/beam_reduction.hpp"
#include "reduce/beams/statics.hpp"
#include "reduce/part/part_input.hpp"

/// What is asked of a structure of beams: nodes and members instead of a CAD file.
namespace flexura::reduce {

/// A solid that a beam part holds: a part file of its own or a finished superelement.
struct SolidInput {
  std::string name;
  std::filesystem::path part, superelement;  ///< one of them
  int modes = -1;                            ///< instead of the part file's; -1: as it says
  std::string where;                         ///< "boom.toml:12: solid.bracket", for messages
};
/// Makes the reduced solid; its interfaces become nodes of the beam model.
using AttachSolid = std::function<AttachedSolid(const SolidInput&)>;

struct BeamPartInput : ReductionRequest {
  beam::Model model;
  std::vector<AttachedSolid> solids;
  std::vector<NodeLink> links;
  beam::Subdivision subdivision;
  std::vector<BeamInterface> interfaces;
  std::vector<LoadCase> cases;
};

}  // namespace flexura::reduce
