// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "mesh/import/imported.hpp"

namespace flexura::mesh {

/// For which program a deck was written, where that makes a difference (*BEAM SECTION).
enum class DeckProgram { unknown, abaqus, calculix };

/// Reads an Abaqus (or CalculiX) input file: *NODE, *ELEMENT of all solid types (C3D4, C3D10, C3D8, C3D20,
/// C3D27, C3D6, C3D15, C3D5 and their variants), *NSET and *ELSET (also GENERATE, INSTANCE), *SOLID SECTION,
/// *MATERIAL with *DENSITY and *ELASTIC (isotropic, engineering constants), *PART, *ASSEMBLY, *INSTANCE
/// (translated and rotated), *INCLUDE.  Steps are read over.  Node sets and element sets become sets of their
/// names; sets of parts in a file of several instances are called "instance.set". Throws
/// std::invalid_argument with file and line.  `program`: unknown is told by what the deck holds.
ImportedModel read_abaqus(const std::filesystem::path& path, DeckProgram program = DeckProgram::unknown);

}  // namespace flexura::mesh
