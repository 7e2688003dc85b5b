// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/model/mesh.hpp"

/// The faces of a mesh that comes without CAD: patches of its surface between sharp edges.
namespace flexura::mesh {

/// Patch number (from 1, by first cell) of each boundary cell, in block order: neighbours belong together
/// where their normals differ by less than `angle` [rad].
std::vector<Index> find_patches(const Mesh& mesh, double angle = 0.6);

/// Unit normal of a surface cell at its middle, from the order of its corners.
Eigen::Vector3d cell_normal(const Mesh& mesh, const CellBlock& block, Index cell);

/// Distance of a point from a surface cell, taken as flat between its corners.
double distance_to_cell(const Mesh& mesh, const CellBlock& block, Index cell, const Eigen::Vector3d& point);

std::size_t count_cells(const std::vector<CellBlock>& blocks);

/// Gives each node set of a mesh the boundary cells that lie wholly in it (area weights).
void attach_faces_to_sets(Mesh& mesh);

}  // namespace flexura::mesh
