// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/input/average.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "reduce/assembly/input/rigid_motion.hpp"
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
  if (!(radius > 0.0)) radius = 1.0;  // one node at the interface's point
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
  // What nodes on a line or in a point do not determine (a rotation about them) is zero: nobody may ask for it
  // (TiedModel::check).  1e-12: as free_motions has it.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(0.5 * (gram + gram.transpose()));
  const auto& values = eigen.eigenvalues();
  if (values(0) > 1e-12 * values(5)) return scale.asDiagonal() * gram.ldlt().solve(WD.transpose());
  const Eigen::Matrix<double, 6, 1> inverse =
      (values.array() > 1e-12 * values(5)).select(values.cwiseInverse(), Eigen::Matrix<double, 6, 1>::Zero());
  return scale.asDiagonal() *
         (eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose()) * WD.transpose();
}

Follower follower_of(mesh::Index point, const Eigen::Matrix<double, 3, 6>& C, const InterfaceSpec& average,
                     const Eigen::Matrix<double, 6, Eigen::Dynamic>& map) {
  Follower follower{.point = point, .from = {}};
  for (std::size_t a = 0; a < average.set.nodes.size(); ++a) {
    Eigen::Matrix<double, 3, 6> of_node = Eigen::Matrix<double, 3, 6>::Zero();
    of_node.leftCols<3>() = C * map.middleCols<3>(3 * static_cast<Eigen::Index>(a));
    follower.from.emplace_back(average.set.nodes[a], of_node);
  }
  return follower;
}

}  // namespace flexura::reduce
