// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/beams/statics.hpp"

#include <stdexcept>

namespace flexura::reduce {

Eigen::VectorXd load_vector(const Structure& structure, const LoadCase& loads) {
  Eigen::VectorXd p = Eigen::VectorXd::Zero(structure.n_dofs());
  p.head(structure.mesh().n_dofs()) = beam::load_vector(structure.mesh(), loads.members);
  for (const auto& [node, load] : loads.nodal) p.segment<6>(6 * node) += load;
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
