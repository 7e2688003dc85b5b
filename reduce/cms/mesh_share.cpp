// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/mesh_share.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "reduce/linalg/dense.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<MeshShare> mesh_share(const Reduction& r) {
  if (r.mesh_error.rows() != r.n() || r.n() == 0) return {};
  constexpr double kUnresolved = std::numeric_limits<double>::infinity();
  MeshShare out;
  const linalg::DenseEigen modes = linalg::generalized_eigen(r.K_se, r.M_se);
  // The six rigid motions stand out by ten powers of ten.
  const double elastic = 1e-9 * modes.values(modes.values.size() / 2);
  for (Index k = 0; k < modes.values.size(); ++k) {
    if (modes.values(k) < elastic) continue;
    const VectorXd y = modes.vectors.col(k);
    const double x = y.dot(r.mesh_error * y) / modes.values(k);
    out.modes.push_back({modes.values(k), x < 1.0 ? 1.0 / std::sqrt(1.0 - x) - 1.0 : kUnresolved});
  }
  int n_interfaces = 0;
  for (const ReducedInterface& interface : r.interfaces) n_interfaces += !interface.directions.empty();
  if (n_interfaces < 2) return out;
  for (const ReducedInterface& interface : r.interfaces) {
    const auto n = static_cast<Index>(interface.directions.size());
    if (n == 0) continue;
    const Eigen::LLT<MatrixXd> K(r.K_se.block(interface.first_dof, interface.first_dof, n, n));
    if (K.info() != Eigen::Success) continue;  // what the others hold does not hold this one
    const MatrixXd C = K.solve(MatrixXd::Identity(n, n));
    const MatrixXd lost = C * r.mesh_error.block(interface.first_dof, interface.first_dof, n, n) * C;
    double worst = 0.0;
    for (Index d = 0; d < n; ++d) worst = std::max(worst, lost(d, d) / C(d, d));
    out.interfaces.push_back({interface.name, worst < 1.0 ? worst : kUnresolved});
  }
  return out;
}

}  // namespace flexura::reduce
