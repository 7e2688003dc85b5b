// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mesh/model/mesh.hpp"
#include "reduce/elements/material.hpp"

/// What is no contradiction but most often a slip: a sentence for the user, or empty.
namespace flexura::reduce {

/// What no solid material has: most often a value without its unit, or a deck (`of_deck`) in other units than it is taken in.
std::string odd_material(const Material& material, bool of_deck = false);

/// Solids of a mesh file without a unit that are longer than solids in metres are: most often millimetres.
std::string odd_size(const mesh::Mesh& mesh);

/// A shell that is thicker than a third of all shells are long: most often a thickness in another unit.
std::string odd_thickness(const mesh::Mesh& mesh);

/// Solids that share an edge or a node alone, in a mesh without shells.
std::string odd_joint(const mesh::Mesh& mesh);

}  // namespace flexura::reduce
