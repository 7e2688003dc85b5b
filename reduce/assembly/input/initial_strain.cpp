// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/input/initial_strain.hpp"

#include "reduce/elements/strain.hpp"

namespace flexura::reduce {

Eigen::MatrixX3d initial_strain_forces(const Part& part, const CellStrains& strain) {
  Eigen::MatrixX3d forces = Eigen::MatrixX3d::Zero(part.mesh.n_nodes(), 3);
  Eigen::Index cell = 0;
  StrainMatrix B;
  NodePositions gradients;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    const Element& element = solid_element(block.type, formulation_of(block, part.formulation));
    NodePositions x(element.n_nodes, 3);
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row, ++cell) {
      if (strain.row(cell).isZero(0.0)) continue;
      for (int a = 0; a < element.n_nodes; ++a) x.row(a) = part.mesh.points.row(block.nodes(row, a));
      const auto& D = part.materials[block.material.empty() ? 0 : block.material[row]].D;
      const Eigen::Matrix<double, 6, 1> stress = D * strain.row(cell).transpose();
      const StrainField field(element, x, D);
      Eigen::VectorXd of_nodes = Eigen::VectorXd::Zero(3 * element.n_nodes);
      for (const TabulatedRule::Point& point : element.stiffness.points) {
        const double det = spatial_gradients(point, x, gradients);
        field.at(point, B);
        of_nodes += (point.weight * det) * (B.transpose() * stress);
      }
      for (int a = 0; a < element.n_nodes; ++a)
        forces.row(block.nodes(row, a)) += of_nodes.segment<3>(3 * a).transpose();
    }
  }
  return forces;
}

}  // namespace flexura::reduce
