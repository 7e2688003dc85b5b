// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/errors/mode_choice.hpp"

#include <algorithm>

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// A cut between two modes that are not one cluster.
bool may_cut(const InteriorDynamics& interior, Index count) {
  if (count == 0 || count == interior.omega2.size()) return true;
  return interior.omega2(count) - interior.omega2(count - 1) > linalg::kClusterGap * interior.omega2(count);
}

}  // namespace

DroppedModes dropped_modes(const InteriorDynamics& interior, const MatrixXd& p,
                           const Eigen::VectorXd& omega2) {
  const Eigen::VectorXd flexibility = omega2.cwiseInverse();
  DroppedModes out{interior.compliance - p.transpose() * flexibility.asDiagonal() * p,
                   interior.growth - p.transpose() * flexibility.cwiseAbs2().asDiagonal() * p};
  out.share = (0.5 * (out.share + out.share.transpose())).eval();
  out.growth = (0.5 * (out.growth + out.growth.transpose())).eval();
  return out;
}

Reduction with_first_modes(const InteriorDynamics& interior, int count) {
  const Index n_b = interior.K_bb.rows();
  Reduction r;
  r.n_b = static_cast<int>(n_b);
  r.n_q = count;
  r.omega2 = interior.omega2.head(count);
  const MatrixXd p = interior.participation.topRows(count);
  r.K_se = MatrixXd::Zero(n_b + count, n_b + count);
  r.K_se.topLeftCorner(n_b, n_b) = interior.K_bb;
  r.K_se.diagonal().tail(count) = r.omega2;
  r.M_se = MatrixXd::Identity(n_b + count, n_b + count);
  r.M_se.topLeftCorner(n_b, n_b) = interior.M_bb;
  r.M_se.bottomLeftCorner(count, n_b) = p;
  r.M_se.topRightCorner(n_b, count) = p.transpose();
  DroppedModes dropped = dropped_modes(interior, p, r.omega2);
  r.dropped = std::move(dropped.share);
  r.dropped_growth = std::move(dropped.growth);
  r.omega2_dropped = count < interior.omega2.size() ? interior.omega2(count) : interior.omega2_next;
  return r;
}

BandError band_error(const Reduction& reduction, double omega) {
  BandError out;
  double cluster = 0.0;
  for (const ModeError& mode : mode_errors(reduction)) {
    if (mode.omega2 > omega * omega) break;
    // Neighbours that are not isolated share their errors: each may have the sum.
    cluster = mode.isolated ? 0.0 : cluster + mode.safe_estimate;
    out.frequency = std::max(out.frequency, 0.5 * std::max(mode.safe_estimate, cluster));
  }
  out.interface = interface_error(reduction, omega);
  return out;
}

std::optional<int> modes_for_accuracy(const InteriorDynamics& interior, double omega, double accuracy) {
  const auto reaches = [&](Index count) {
    return band_error(with_first_modes(interior, static_cast<int>(count)), omega).worst() <= accuracy;
  };
  // Modes below the band's end are needed whatever the estimate says; from there errors fall with the count.
  Index low = 0, high = interior.omega2.size();
  while (low < high && interior.omega2(low) <= omega * omega) ++low;
  if (!reaches(high)) return std::nullopt;
  while (low < high) {
    const Index middle = (low + high) / 2;
    if (reaches(middle))
      high = middle;
    else
      low = middle + 1;
  }
  while (!may_cut(interior, high)) ++high;
  return static_cast<int>(high);
}

std::optional<int> modes_for_effective_mass(const InteriorDynamics& interior, const MatrixXd& R_b,
                                            const MatrixXd& interior_mass, double fraction) {
  Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
  const Eigen::Matrix<double, 6, 1> wanted = fraction * interior_mass.diagonal();
  for (Index count = 0; count <= interior.omega2.size(); ++count) {
    if ((sum.array() >= wanted.array()).all() && may_cut(interior, count)) return static_cast<int>(count);
    if (count < interior.omega2.size())
      sum += (R_b.transpose() * interior.participation.row(count).transpose()).cwiseAbs2();
  }
  return std::nullopt;
}

}  // namespace flexura::reduce
