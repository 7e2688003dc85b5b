// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/result/load_case.hpp"

#include <Eigen/Geometry>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

Eigen::MatrixXd nodal_forces(const linalg::SymmetricMatrix& m, Eigen::Index n_nodes, const LoadField& load) {
  const Eigen::Index n = 3 * n_nodes;
  Eigen::MatrixXd F = Eigen::MatrixXd::Zero(n, 1);
  if (load.acceleration.rows() > 0)
    m.multiply_kron3(Eigen::MatrixXd(load.acceleration.transpose().reshaped(n, 1)), F);
  if (load.forces.rows() > 0) F += load.forces.transpose().reshaped(n, 1);
  return F;
}

ReducedLoad reduced_load(const LoadField& load, const Eigen::MatrixXd& T, const linalg::SymmetricMatrix& m) {
  const auto times_axis = [](const Eigen::MatrixX3d& field, int a) {
    Eigen::MatrixX3d turned(field.rows(), 3);
    for (Eigen::Index i = 0; i < field.rows(); ++i)
      turned.row(i) = field.row(i).cross(Eigen::RowVector3d::Unit(a));
    return turned;
  };
  const Eigen::Index n_nodes = T.rows() / 3;
  Eigen::MatrixXd forces = nodal_forces(m, n_nodes, load);
  forces.conservativeResize(Eigen::NoChange, 4);
  LoadField turned;
  for (int a = 0; a < 3; ++a) {
    turned.forces = times_axis(load.forces, a);
    turned.acceleration = times_axis(load.acceleration, a);
    forces.col(1 + a) = nodal_forces(m, n_nodes, turned);
  }
  const Eigen::MatrixXd on_shapes = linalg::transpose_times(T, forces);
  return {load.name, on_shapes.col(0), on_shapes.rightCols<3>().transpose(), load.strain.rows() > 0};
}

}  // namespace flexura::reduce
