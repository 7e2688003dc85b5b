// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh/import/abaqus/abaqus_deck.hpp"
#include "mesh/import/abaqus/abaqus_keywords.hpp"

/// Keywords that bind dofs: *COUPLING, *RIGID BODY, *MPC, *TIE, *EQUATION.
namespace flexura::mesh::abaqus {

/// Puts what the keyword says into the deck; false where it is none of them.  Throws std::invalid_argument, naming file and
/// line.
bool take_binding(const Keyword& k, Deck& deck);

}  // namespace flexura::mesh::abaqus
