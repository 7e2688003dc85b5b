// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/SparseCore>
#include <span>

#include "mesh/model/mesh.hpp"

/// Integrals over faces of elements, with the faces' own shape functions (tri3, tri6, quad4, quad8, quad9).
namespace flexura::reduce {

/// The surface mass matrix  W_ac = integral N_a N_c dA  [m^2] over all the given faces, in the numbering of
/// `nodes` (ascending).  Its sum is the area.  Faces with a node outside `nodes` are refused
/// (std::invalid_argument), as are cell types that are not faces.
Eigen::SparseMatrix<double> surface_mass(const mesh::Mesh& mesh, std::span<const mesh::CellBlock> faces,
                                         std::span<const mesh::Index> nodes);

/// The unit-pressure load: row a = integral N_a n dA [m^2], n the outward normal of the faces' orientation; a
/// pressure pushes against it.  n_nodes x 3.
Eigen::Matrix<double, Eigen::Dynamic, 3> pressure_load(const mesh::Mesh& mesh,
                                                       std::span<const mesh::CellBlock> faces);

}  // namespace flexura::reduce
