// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "reduce/assembly/input/part.hpp"

namespace flexura::reduce {

/// Stiffness, mass and (where a file is given) damping matrix that another program assembled: Matrix Market ("coordinate real symmetric" or
/// "general"), Abaqus' coordinate format (row, column, value) or its matrix input (node, direction, node,
/// direction, value); gzipped or not.  Rows count the nodes of the mesh in ascending number, three directions
/// each.  One triangle or both may be given.  Throws std::invalid_argument, naming file and line, for entries
/// beyond the nodes, for two triangles that differ, and for a mass matrix that is not m (x) I_3: inertia
/// integrals of rotational masses cannot be had from a matrix.
NodalMatrices read_matrices(const std::filesystem::path& stiffness, const std::filesystem::path& mass,
                            const std::filesystem::path& damping, const mesh::Mesh& mesh);

/// The mass alone, as above, without stiffness.
NodalMatrices read_mass_matrix(const std::filesystem::path& mass, const mesh::Mesh& mesh);

/// A dense matrix: Matrix Market ("array", general or symmetric, or "coordinate"), or plain text, one row a
/// line; gzipped or not.
Eigen::MatrixXd read_dense(const std::filesystem::path& path);

/// Nodes alone, one a line: number, x, y, z, separated by commas or blanks; # begins a comment.
mesh::Mesh read_nodes(const std::filesystem::path& path);

}  // namespace flexura::reduce
