// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh/gmsh/cad.hpp"

namespace flexura::mesh {

/// The faces of a CAD file that holds no solid, without meshing them.
CadReport list_sheet(const CadOptions& options, const Progress& progress = {});

/// Meshes them as the middle surface of a sheet: mesh.shells of this thickness [m], boundary and boundary_face as of solids.
/// Faces that meet are joined.  The report's volumes are areas times the thickness.  Throws std::invalid_argument for a file
/// with solids or without faces, for a thickness that is not above 0, that is more than half the width of the sheet (area over
/// half its free outline; a closed one: root of the area), or than a bend's diameter; std::runtime_error where gmsh fails.
CadMesh mesh_sheet(const CadOptions& options, double thickness, const Progress& progress = {});

}  // namespace flexura::mesh
