// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/beams/statics.hpp"

#include <stdexcept>

namespace flexura::reduce {

double preload_of(const LoadCase& loads, int member) {
  double N = 0.0;
  for (const auto& [of, preload] : loads.preloads)
    if (of == member) N += preload;
  return N;
}

Eigen::VectorXd load_vector(const Structure& structure, const LoadCase& loads) {
  Eigen::VectorXd p = Eigen::VectorXd::Zero(structure.n_dofs());
  p.head(structure.mesh().n_dofs()) = beam::load_vector(structure.mesh(), loads.members);
  for (const auto& [node, load] : loads.nodal) p.segment<6>(6 * node) += load;
  // A member too short pulls its nodes together, wherever its axis runs beside them.
  if (loads.preloads.empty()) return p;
  for (const beam::MeshElement& record : structure.mesh().elements()) {
    const double N = preload_of(loads, record.member);
    if (N == 0.0) continue;
    beam::Vector12d of_ends = beam::Vector12d::Zero();
    of_ends(0) = N;
    of_ends(6) = -N;
    const beam::Vector12d of_nodes = record.placement.transform().transpose() * of_ends;
    p.segment<6>(6 * record.node[0]) += of_nodes.head<6>();
    p.segment<6>(6 * record.node[1]) += of_nodes.tail<6>();
  }
  return p;
}

Eigen::MatrixXd static_displacements(const Structure& structure, const std::vector<BeamInterface>& held,
                                     const std::vector<LoadCase>& cases) {
  const Numbering numbering(structure, held);
  const SplitMatrix K(structure.stiffness(), numbering);
  const linalg::CholeskyFactor factor = factorise(structure, numbering, K);
  const Eigen::Index n = static_cast<Eigen::Index>(cases.size());
  Eigen::MatrixXd P(structure.n_dofs(), n);
  for (Eigen::Index k = 0; k < n; ++k) P.col(k) = load_vector(structure, cases[k]);
  const Eigen::MatrixXd inside = solve_refined(factor, *K.ii, P(numbering.dof_of, Eigen::all));
  if (!inside.allFinite())
    throw std::runtime_error("the displacements under static load hold a number that is not finite");
  Eigen::MatrixXd U = Eigen::MatrixXd::Zero(structure.n_dofs(), n);
  U(numbering.dof_of, Eigen::all) = inside;
  return U;
}

}  // namespace flexura::reduce
