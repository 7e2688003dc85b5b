// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/mesh_share.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "reduce/cms/reduction.hpp"
#include "reduce/linalg/dense.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

JudgedMotions judged_motions(const Reduction& r, double omega_max) {
  constexpr int kLeast = 10, kMost = 60;
  JudgedMotions out;
  std::vector<VectorXd> y, force;
  std::vector<double> lambda, energy;
  const linalg::DenseEigen modes = linalg::generalized_eigen(r.K_se, r.M_se);
  const double elastic = least_elastic(modes.values);
  for (Index k = 0; k < modes.values.size(); ++k) {
    const double omega2 = modes.values(k);
    if (omega2 <= elastic) continue;
    if (out.n_modes >= kMost || (out.n_modes >= kLeast && omega2 > omega_max * omega_max)) break;
    y.emplace_back(modes.vectors.col(k));
    force.emplace_back(VectorXd::Zero(r.n_b));
    lambda.push_back(omega2);
    energy.push_back(omega2);
    ++out.n_modes;
  }
  int n_interfaces = 0;
  for (const ReducedInterface& interface : r.interfaces) n_interfaces += !interface.directions.empty();
  for (const ReducedInterface& interface : r.interfaces) {
    const auto n = static_cast<Index>(interface.directions.size());
    if (n == 0 || n_interfaces < 2) continue;
    // Of two that hold each other with all six directions, the answers differ by a rigid motion: one is enough.
    if (n_interfaces == 2 && n == 6 && !out.names.empty() && out.n_directions.front() == 6) {
      out.names.push_back(interface.name);
      out.n_directions.push_back(0);
      continue;
    }
    const Eigen::LLT<MatrixXd> K(r.K_se.block(interface.first_dof, interface.first_dof, n, n));
    if (K.info() != Eigen::Success) continue;  // what the others hold does not hold this one
    const MatrixXd C = K.solve(MatrixXd::Identity(n, n));
    for (Index d = 0; d < n; ++d) {
      VectorXd answer = VectorXd::Zero(r.n());
      answer.segment(interface.first_dof, n) = C.col(d);
      force.emplace_back(r.K_se.topRows(r.n_b) * answer);
      y.push_back(std::move(answer));
      lambda.push_back(0.0);
      energy.push_back(C(d, d));
    }
    out.names.push_back(interface.name);
    out.n_directions.push_back(static_cast<int>(n));
  }
  const auto n = static_cast<Index>(y.size());
  out.states.Y.resize(r.n(), n);
  out.states.force.resize(r.n_b, n);
  for (Index k = 0; k < n; ++k) {
    out.states.Y.col(k) = y[static_cast<std::size_t>(k)];
    out.states.force.col(k) = force[static_cast<std::size_t>(k)];
  }
  out.states.lambda = Eigen::Map<const VectorXd>(lambda.data(), n);
  out.energy = Eigen::Map<const VectorXd>(energy.data(), n);
  return out;
}

MeshShare mesh_share(const JudgedMotions& motions, const MeshEnergy& left) {
  constexpr double kUnresolved = std::numeric_limits<double>::infinity();
  MeshShare out;
  const VectorXd x = left.energy.cwiseQuotient(motions.energy);
  Index at = 0;
  for (; at < motions.n_modes; ++at)
    out.modes.push_back(
        {motions.states.lambda(at), x(at) < 1.0 ? 1.0 / std::sqrt(1.0 - x(at)) - 1.0 : kUnresolved});
  for (std::size_t k = 0; k < motions.names.size(); ++k) {
    const bool as_the_first = motions.n_directions[k] == 0;
    const double worst = x.segment(as_the_first ? motions.n_modes : at,
                                   motions.n_directions[as_the_first ? 0 : k]).maxCoeff();
    at += motions.n_directions[k];
    out.interfaces.push_back({motions.names[k], worst < 1.0 ? worst : kUnresolved});
  }
  out.by_cell = left.by_cell * motions.energy.cwiseInverse().cast<float>().asDiagonal();
  return out;
}

}  // namespace flexura::reduce
