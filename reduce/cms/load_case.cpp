// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/load_case.hpp"

#include <Eigen/Geometry>

#include "reduce/linalg/dense.hpp"

namespace flexura::reduce {

ReducedLoad reduced_load(const LoadField& load, const Eigen::MatrixXd& T,
                         const std::function<Eigen::MatrixXd(const LoadField&)>& forces_on_dofs) {
  const auto times_axis = [](const Eigen::MatrixX3d& field, int a) {
    Eigen::MatrixX3d turned(field.rows(), 3);
    for (Eigen::Index i = 0; i < field.rows(); ++i)
      turned.row(i) = field.row(i).cross(Eigen::RowVector3d::Unit(a));
    return turned;
  };
  Eigen::MatrixXd forces = forces_on_dofs(load);
  forces.conservativeResize(Eigen::NoChange, 4);
  LoadField turned;
  for (int a = 0; a < 3; ++a) {
    turned.forces = times_axis(load.forces, a);
    turned.acceleration = times_axis(load.acceleration, a);
    forces.col(1 + a) = forces_on_dofs(turned);
  }
  const Eigen::MatrixXd on_shapes = linalg::transpose_times(T, forces);
  return {load.name, on_shapes.col(0), on_shapes.rightCols<3>().transpose()};
}

}  // namespace flexura::reduce
