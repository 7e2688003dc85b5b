// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"

/// Small parts for the tests of reduce/.
namespace flexura::reduce::testing {

/// A box 0 <= x, y, z <= size of n[0] x n[1] x n[2] cells of the given type; tetrahedra: six in each brick,
/// wedges two, pyramids six.  Numbers of nodes run with x fastest for tet4 and hex8.
mesh::Mesh box(const Eigen::Vector3d& size, const std::array<int, 3>& n, mesh::CellType type);

/// Moves every point; with `straight` the mid-edge nodes go back to the middle of their corners.
void deform(mesh::Mesh& mesh, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map,
            bool straight = false);

/// The nodes at which `inside` holds, and the outer faces that lie between them (needs mesh.boundary).
mesh::NodeSet nodes_where(const mesh::Mesh& mesh, const std::function<bool(const Eigen::Vector3d&)>& inside);

/// Steel: E = 2.1e11 Pa, nu = 0.3, 7850 kg/m^3.
Material steel();

/// A box of steel with interfaces "left" (face x = 0) and "right" (face x = size(0)), each with its node at
/// the face's centre.
Part beam(const Eigen::Vector3d& size, const std::array<int, 3>& n, mesh::CellType type, Tie left, Tie right);

/// Nodes and elements of an Abaqus input deck, by a reader just good enough for the decks in data/.
mesh::Mesh read_abaqus(const std::string& path, mesh::CellType type);

/// A matrix "row column value" (from 1), gzipped, both triangles stored.
Eigen::MatrixXd read_coordinates(const std::string& path, int n);

/// The dense form of what the library keeps sparse.
Eigen::MatrixXd dense(const linalg::SymmetricMatrix& matrix);

/// m (x) I_3.
Eigen::MatrixXd kron3(const Eigen::MatrixXd& m);

/// A vector of pseudo-random numbers in [-1, 1], the same every time.
Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index cols, unsigned seed = 1);

}  // namespace flexura::reduce::testing
