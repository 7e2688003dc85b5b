// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/part/part_mesh.hpp"

/// Materials of a deck.
namespace flexura::reduce {

/// part.materials: those of `model`, in SI, or of the part file that have the same name; their damping is the deck's.  Where the deck
/// has none, the part file must give exactly one.  Throws input::InputError, and std::invalid_argument for materials that lack a
/// constant or that no section assigns.
void choose_materials(const PartInput& input, const mesh::ImportedModel& model, PartMesh& part);

/// Tells in part.messages what the materials damp.
void say_damping(PartMesh& part);

}  // namespace flexura::reduce
