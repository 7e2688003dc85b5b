// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "reduce/assembly/input/part.hpp"

namespace flexura::reduce {

/// Mass by which rotations of two nodes a <= b (or of one) are accelerated, beside m u_a . u_b:
///
///     u_a . (theta_b x moment_of_second) + u_b . (theta_a x moment_of_first) + theta_a . inertia theta_b,
///
/// of which the equations of motion have the mirror image as well where a < b.  Of one node with the mass m at c
/// and J about it: both moments m c, inertia J - m [c]^2.
struct TurningMass {
  std::array<mesh::Index, 2> nodes{-1, -1};
  Eigen::Vector3d moment_of_first = Eigen::Vector3d::Zero();   ///< [kg m]
  Eigen::Vector3d moment_of_second = Eigen::Vector3d::Zero();  ///< [kg m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();           ///< [kg m^2]
};

/// Matrices of another program, in the units of their files.
struct GivenMatrices {
  NodalMatrices u;                   ///< of displacements
  std::vector<FrameElement> frames;  ///< K and D of what has to do with rotations
  std::vector<TurningMass> turning;
};

/// Stiffness, mass and (where a file is given) damping matrix that another program assembled: Matrix Market ("coordinate real symmetric" or
/// "general"), Abaqus' coordinate format (row, column, value) or its matrix input (node, direction, node,
/// direction, value), DMIG of Nastran (nastran_matrices.hpp); gzipped or not; or its OUTPUT4 (op4.hpp).  Rows count the nodes of the mesh in ascending
/// number, three directions each or six (u, theta), as K and M tell by their size.  One triangle or both may be given.  Throws
/// std::invalid_argument, naming file and line, for entries beyond the nodes, for two triangles that differ, for rotary inertia
/// where K has no rotation, and for a mass matrix that does not say how the mass is placed (inertia integrals want that):
/// displacements other than m (x) I_3, or coupled to rotations other than by an offset.
GivenMatrices read_matrices(const std::filesystem::path& stiffness, const std::filesystem::path& mass,
                            const std::filesystem::path& damping, const mesh::Mesh& mesh);

/// The mass alone, as above, without stiffness.
GivenMatrices read_mass_matrix(const std::filesystem::path& mass, const mesh::Mesh& mesh);

/// In other units: mass [kg] and length [m] of theirs.
void scale(GivenMatrices& matrices, double unit_mass, double unit_length);

/// Makes them the part's, instead of its elements; of shells the faces are left, as what is seen.  Rotary inertia becomes
/// masses of points that follow the nodes, which come last in the mesh.
void take_in(GivenMatrices&& given, Part& part);

/// A dense matrix: Matrix Market ("array", general or symmetric, or "coordinate"), or plain text, one row a
/// line; gzipped or not; or OUTPUT4 of Nastran, of several matrices that whose name begins with `letter`.
Eigen::MatrixXd read_dense(const std::filesystem::path& path, char letter = '\0');

/// Nodes alone, one a line: number, x, y, z, separated by commas or blanks; # begins a comment.
mesh::Mesh read_nodes(const std::filesystem::path& path);

}  // namespace flexura::reduce
