// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "mesh/import/imported.hpp"

namespace flexura::mesh {

/// Reads Nastran bulk data in free, small and large field: GRID (with GRDSET and coordinate systems
/// CORD1R/C/S, CORD2R/C/S), CTETRA, CHEXA, CPENTA, CPYRAM (linear and quadratic), PSOLID, MAT1, CBAR and
/// CBEAM with PBAR and PBEAM (end A), RBE2, RBE3, CONM2, SPC, SPC1, ASET, ASET1, INCLUDE.  Solids of one
/// property become a set "property N". Everything else is named in the messages.  Throws
/// std::invalid_argument with file and line.
ImportedModel read_nastran(const std::filesystem::path& path);

}  // namespace flexura::mesh
