// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "reduce/assembly/input/initial_strain.hpp"

/// Stress modes: the stresses of each shape, sigma = sum_k sigma_k u_se,k at run time.
namespace flexura::reduce {

/// Nodal stresses of the displacement shapes T (3 n_nodes x n) at the given nodes: 6 n_v x n, rows (xx, yy,
/// zz, xy, yz, zx) [Pa per unit of the shape] of the first node, then of the second, ...  Each cell's stress
/// D B h is taken at the node itself; the nodal value is the mean over the cells of one material that share
/// the node (of the material with most cells there: stresses jump where materials meet).
/// Of shells the points of their skins are nodes: membrane and bending stress there; of beams those of
/// Part::beam_stresses.  `rotations` are those of the
/// shapes at the nodes that turn (TiedModel::expand_rotations), `rotation_of` each node's place among them; both may
/// be empty without shells and beams.
Eigen::MatrixXd nodal_stress_modes(const Part& part, const Eigen::MatrixXd& T,
                                   const std::vector<mesh::Index>& nodes,
                                   const Eigen::MatrixXd& rotations = {},
                                   const std::vector<int>& rotation_of = {});

/// 6 n_v: the stress -D e of initial strains of the cells with every node held, by the same means: what a preload adds to the
/// stress of the displacements.
Eigen::VectorXd nodal_initial_stress(const Part& part, const CellStrains& strain,
                                     const std::vector<mesh::Index>& nodes);

/// That material (index) of each node, and how many of its cells share the node; -1 and 0 where no
/// stress is known.
std::vector<std::pair<int, int>> nodal_materials(const Part& part, const std::vector<mesh::Index>& nodes);

}  // namespace flexura::reduce
