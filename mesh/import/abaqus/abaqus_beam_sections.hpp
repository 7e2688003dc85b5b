// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mesh/import/abaqus.hpp"
#include "mesh/import/abaqus/abaqus_keywords.hpp"
#include "mesh/import/bar_sections.hpp"
#include "mesh/import/builder.hpp"

/// *BEAM SECTION, in which Abaqus and CalculiX mean different things by the same words.
namespace flexura::mesh::abaqus {

/// For which of the two a deck was written, by what one of them alone knows; unknown where it has nothing of either or
/// something of both.
DeckProgram written_for(const std::vector<Keyword>& keywords);

/// The section of *BEAM SECTION (or *BEAM GENERAL SECTION by its shape).  CalculiX takes the numbers of CIRC for the thicknesses
/// in the directions 1 and 2, the second being the first where it is missing, Abaqus the first for the radius; OFFSET1 and OFFSET2 are
/// CalculiX' place of the nodes from the axis, in thicknesses.  What is guessed or left out is put into `otherwise`.
/// Throws std::invalid_argument.
BarSection shaped_section(const Keyword& k, DeckProgram program, Unused& otherwise);

}  // namespace flexura::mesh::abaqus
