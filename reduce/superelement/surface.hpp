// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/superelement/superelement.hpp"
#include "mesh/model/mesh.hpp"

namespace flexura::reduce {

/// The outer surface of a mesh for pictures.
struct SurfacePicture {
  superelement::Surface surface;
  std::vector<mesh::Index> nodes;  ///< n_v: node of the mesh at each vertex, ascending
};

/// Boundary cells become triangles (six-node ones four each, four-node quadrilaterals two).  Feature edges
/// lie between boundary cells of different CAD faces or, where the mesh knows no faces, of normals more than
/// 30 degrees apart. A triangle belongs to interface k when all its vertices are in interface_nodes[k].
SurfacePicture make_surface(const mesh::Mesh& mesh,
                            const std::vector<std::vector<mesh::Index>>& interface_nodes);

}  // namespace flexura::reduce
