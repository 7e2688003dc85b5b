// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/cms/result/mesh_share.hpp"

namespace flexura::reduce {

/// Why a mesh is too stiff, for people who have to mend it: elements larger than the part is thick, elements of order 1,
/// one element through the thickness, a nearly incompressible material.  Warnings where the mesh's error is unknown or
/// estimated beyond 5 % in the first frequency or in statics, notes beyond 1 %, else nothing: the reasons do no harm.  A
/// nearly incompressible material is always warned of: the estimate does not see what it does; so are meshes that came with
/// the part and are open where nodes lie in one place.
struct MeshHints {
  std::vector<std::string> warnings, notes;
};

/// size: greatest edge length asked for [m], 0 where the mesh came with the part or has sizes of its own everywhere.
MeshHints mesh_hints(const Part& part, double size, const std::optional<MeshShare>& share);

}  // namespace flexura::reduce
