// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

#include "mesh/import/abaqus/abaqus_deck.hpp"

/// *SOLID SECTION, *SHELL SECTION, *SHELL GENERAL SECTION, *BEAM SECTION and *BEAM GENERAL SECTION.
namespace flexura::mesh::abaqus {

/// True for these.
bool gives_section(const std::string& name);

/// What one of them says.  `known` gives a name as the deck first spelt it.  The material of *BEAM GENERAL SECTION and what is not
/// read go into `deck`.  Throws std::invalid_argument, naming file and line.
Section section_of(const Keyword& k, DeckProgram program,
                   const std::function<std::string(const std::string&)>& known, Deck& deck);

}  // namespace flexura::mesh::abaqus
