// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/average.hpp"

#include <Eigen/Cholesky>

#include "reduce/assembly/rigid_motion.hpp"
#include "reduce/elements/surface.hpp"

namespace flexura::reduce {

Eigen::Matrix<double, 6, Eigen::Dynamic> averaging_map(const mesh::Mesh& mesh,
                                                       const InterfaceSpec& interface) {
  const auto& nodes = interface.set.nodes;
  const auto n = static_cast<Eigen::Index>(nodes.size());
  // D and W D with one row of three for each node.  Rotations are measured in units of the set's radius
  // meanwhile, so that the 6 x 6 system is well conditioned in any unit of length.
  double radius = 0.0;
  for (mesh::Index node : nodes)
    radius = std::max(radius, (mesh.points.row(node).transpose() - interface.point).norm());
  Eigen::Matrix<double, 6, 1> scale;
  scale << 1, 1, 1, 1 / radius, 1 / radius, 1 / radius;
  Eigen::Matrix<double, Eigen::Dynamic, 6> D(3 * n, 6), WD(3 * n, 6);
  for (Eigen::Index a = 0; a < n; ++a)
    D.middleRows<3>(3 * a) =
        motion_at(mesh.points.row(nodes[a]).transpose() - interface.point) * scale.asDiagonal();
  if (!interface.weights.empty()) {
    for (Eigen::Index a = 0; a < n; ++a)
      WD.middleRows<3>(3 * a) = interface.weights[a] * D.middleRows<3>(3 * a);
  } else if (interface.set.faces.empty()) {
    WD = D;
  } else {
    const Eigen::SparseMatrix<double> W = surface_mass(mesh, interface.set.faces, nodes);
    WD.setZero();
    for (Eigen::Index c = 0; c < n; ++c)
      for (Eigen::SparseMatrix<double>::InnerIterator it(W, c); it; ++it)
        WD.middleRows<3>(3 * it.row()) += it.value() * D.middleRows<3>(3 * c);
  }
  const Eigen::Matrix<double, 6, 6> gram = D.transpose() * WD;
  return scale.asDiagonal() * gram.ldlt().solve(WD.transpose());
}

}  // namespace flexura::reduce
