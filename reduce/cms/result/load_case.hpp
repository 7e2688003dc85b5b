// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>

#include "reduce/assembly/input/initial_strain.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"

namespace flexura::reduce {

/// A load case: forces on the nodes and accelerations of the mass, which act as m a.
struct LoadField {
  std::string name;
  Eigen::MatrixX3d forces;        ///< n_nodes x 3 [N], or empty
  Eigen::MatrixX3d acceleration;  ///< n_nodes x 3 [m/s^2], interpolated like displacements, or empty
  bool keep_shape = false;        ///< the interior's static answer becomes a shape, too
  CellStrains strain = {};        ///< of a preload, whose `forces` are those of this strain; or empty
};

/// 3 n_nodes x 1 [N], row 3 i + a: the forces of the field on the nodes; `m` n_nodes x n_nodes [kg], the mass
/// of each direction.
Eigen::MatrixXd nodal_forces(const linalg::SymmetricMatrix& m, Eigen::Index n_nodes, const LoadField& load);

/// The load on the shapes T (3 n_nodes x n; theory: p_SE = T^T p_FEM).
///
/// Its torque about Bo by displacement follows from the same forces turned: as e_a . (phi x p) = phi . (p x
/// e_a), row a of `moment` is T^T of the field p x e_a.
ReducedLoad reduced_load(const LoadField& load, const Eigen::MatrixXd& T, const linalg::SymmetricMatrix& m);

}  // namespace flexura::reduce
