// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/result/mesh_share.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "reduce/cms/result/reduction.hpp"
#include "reduce/estimate/sharp_edges.hpp"
#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// What others do not hold has a motion without stiffness, of which round-off leaves a little of either sign.  With ones on the
// diagonal whatever is held has more than the digits that a condensed stiffness has.
bool is_held(const MatrixXd& K) {
  constexpr double kDigits = 1e-10;
  if (!(K.diagonal().array() > 0.0).all()) return false;
  const VectorXd scale = K.diagonal().cwiseSqrt().cwiseInverse();
  return linalg::symmetric_eigen(scale.asDiagonal() * K * scale.asDiagonal()).values(0) > kDigits;
}

}  // namespace

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
    const MatrixXd K = r.K_se.block(interface.first_dof, interface.first_dof, n, n);
    if (!is_held(K)) continue;
    const MatrixXd C = K.llt().solve(MatrixXd::Identity(n, n));
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
  const auto stress = [&](double share) {
    return MeshShare::Stress{.mean = std::sqrt(std::clamp(share, 0.0, 1.0))};
  };
  for (Index at = 0; at < motions.n_modes; ++at)
    out.modes.push_back({motions.states.lambda(at),
                         x(at) < 1.0 ? 1.0 / std::sqrt(1.0 - x(at)) - 1.0 : kUnresolved, stress(x(at))});
  for (std::size_t k = 0; k < motions.names.size(); ++k) {
    const auto [first, n] = motions.states_of(k);
    const double worst = x.segment(first, n).maxCoeff();
    out.interfaces.push_back({motions.names[k], worst < 1.0 ? worst : kUnresolved, stress(worst)});
  }
  out.by_cell = left.by_cell * motions.energy.cwiseInverse().cast<float>().asDiagonal();
  return out;
}

std::pair<Index, Index> JudgedMotions::states_of(std::size_t interface) const {
  if (n_directions[interface] == 0) return states_of(0);
  Index first = n_modes;
  for (std::size_t k = 0; k < interface; ++k) first += n_directions[k];
  return {first, n_directions[interface]};
}

void leave_out_concentrated(const Part& part, const JudgedMotions& motions, MeshShare& share) {
  const bool any =
      std::any_of(part.interfaces.begin(), part.interfaces.end(),
                  [&](const InterfaceSpec& interface) { return is_concentrated(part, interface); });
  if (!any) return;
  for (std::size_t k = 0; k < share.interfaces.size(); ++k) {
    share.interfaces[k].error = -1.0;
    share.interfaces[k].stress.mean = -1.0;
    const auto [first, n] = motions.states_of(k);
    share.by_cell.middleCols(first, n).setZero();  // no finer mesh asked for there
  }
}

void add_peaks(const JudgedMotions& motions, const std::vector<PeakStress>& peaks, MeshShare& share) {
  for (std::size_t k = 0; k < share.modes.size(); ++k) share.modes[k].stress.peak = peaks[k];
  for (std::size_t k = 0; k < share.interfaces.size(); ++k) {
    const auto [first, n] = motions.states_of(k);
    PeakStress& worst = share.interfaces[k].stress.peak;
    for (Index state = first; state < first + n; ++state) {
      const PeakStress& peak = peaks[static_cast<std::size_t>(state)];
      const PeakStress before = worst;
      if (peak.error > worst.error) worst = peak;
      if (!peak.singular && before.singular) worst.singular_at = before.singular_at;
      if (peak.singular) worst.singular_at = peak.singular_at;
      worst.singular = before.singular || peak.singular;
    }
  }
}

}  // namespace flexura::reduce
