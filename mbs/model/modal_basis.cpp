// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/modal_basis.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Modes {
  MatrixXd Y;
  VectorXd omega2;
};

Modes free_modes(const superelement::Superelement& se) {
  const int n = se.n();
  // Displacements, rotations and modal coordinates differ in size: unit diagonal of M first.
  VectorXd scale(n);
  for (int i = 0; i < n; ++i) {
    if (!(se.M_se(i, i) > 0.0))
      throw std::invalid_argument(fmt::format(
          "superelement \"{}\": M_se has the diagonal entry {} in row {}; every coordinate needs inertia",
          se.name, se.M_se(i, i), i));
    scale(i) = 1.0 / std::sqrt(se.M_se(i, i));
  }
  const MatrixXd M = scale.asDiagonal() * se.M_se * scale.asDiagonal();
  const MatrixXd K = scale.asDiagonal() * se.K_se * scale.asDiagonal();
  const MatrixXd R = scale.cwiseInverse().asDiagonal() * superelement::rigid_motions(se);

  // The complement of M R: the last n - 6 columns of its orthogonal factor.
  Eigen::ColPivHouseholderQR<MatrixXd> qr(M * R);
  qr.setThreshold(1e-9);
  if (n <= 6 || qr.rank() != 6)
    throw std::invalid_argument(fmt::format(
        "superelement \"{}\" has {} coordinates that carry {} of the six rigid motions; a flexible body "
        "needs all "
        "six and at least one more coordinate (use fidelity = \"rigid\" or interfaces with more directions)",
        se.name, n, qr.rank()));
  const MatrixXd N = qr.householderQ() * MatrixXd::Identity(n, n).rightCols(n - 6);
  const MatrixXd K_c = N.transpose() * K * N, M_c = N.transpose() * M * N;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(0.5 * (K_c + K_c.transpose()),
                                                                  0.5 * (M_c + M_c.transpose()));
  if (solver.info() != Eigen::Success)
    throw std::invalid_argument(
        fmt::format("superelement \"{}\": M_se is not positive definite beside its rigid motions", se.name));
  Modes modes{scale.asDiagonal() * (N * solver.eigenvectors()), solver.eigenvalues()};
  if (!(modes.omega2(0) > 0.0))
    throw std::invalid_argument(fmt::format(
        "superelement \"{}\": K_se has a mode without stiffness beside the six rigid motions (omega^2 = {})",
        se.name, modes.omega2(0)));
  // A sign that does not depend on the eigensolver: the largest entry is positive.
  for (int i = 0; i < modes.Y.cols(); ++i) {
    Eigen::Index k = 0;
    modes.Y.col(i).cwiseProduct(scale.cwiseInverse()).cwiseAbs().maxCoeff(&k);
    if (modes.Y(k, i) < 0.0) modes.Y.col(i) *= -1.0;
  }
  return modes;
}

}  // namespace

superelement::InertiaIntegrals transform(const superelement::InertiaIntegrals& in, const MatrixXd& Y) {
  superelement::InertiaIntegrals out;
  out.mass = in.mass;
  out.S_x = in.S_x;
  out.S_xx = in.S_xx;
  out.S_phi = in.S_phi * Y;
  out.S_xphi = in.S_xphi * Y;
  for (int k = 0; k < 6; ++k) out.S_phiphi[k] = Y.transpose() * in.S_phiphi[k] * Y;
  return out;
}

ModalData modal_data(const superelement::Superelement& se, const BasisOptions& options, BasisReport* report) {
  Modes modes = free_modes(se);
  const VectorXd omega = modes.omega2.cwiseSqrt();
  const auto hz = [&](int i) { return omega(i) / (2.0 * std::numbers::pi); };
  const int available = static_cast<int>(omega.size());
  int kept = 0;
  while (kept < available && kept < options.modes && hz(kept) <= options.max_frequency) ++kept;
  if (kept == 0)
    throw std::invalid_argument(
        fmt::format("superelement \"{}\": no mode is left (the first one has {:.6g} Hz); keep one or use "
                    "fidelity = \"rigid\"",
                    se.name, hz(0)));
  if (report) *report = {available, kept, hz(0), hz(kept - 1), kept < available ? hz(kept) : 0.0};

  ModalData data;
  data.Y = modes.Y.leftCols(kept);
  data.stiffness = modes.omega2.head(kept);
  data.inertia = transform(se.inertia, data.Y);
  if (se.D_se.size() > 0 && !options.damping) {
    // Of a general D_se the modes keep what acts within each mode.
    data.damping = (data.Y.transpose() * se.D_se * data.Y).diagonal();
  } else {
    data.damping = 2.0 * options.damping.value_or(se.modal_damping) * omega.head(kept);
  }
  for (const superelement::Interface& interface : se.interfaces) {
    FlexibleNode node;
    node.name = interface.name;
    node.p_BoN_B = interface.p_BoN_B;
    node.Phi_t = node.Phi_r = Eigen::Matrix3Xd::Zero(3, kept);
    for (std::size_t k = 0; k < interface.directions.size(); ++k) {
      const int direction = static_cast<int>(interface.directions[k]);
      const auto row = data.Y.row(interface.first_dof + static_cast<int>(k));
      if (direction < 3)
        node.Phi_t.row(direction) = row;
      else
        node.Phi_r.row(direction - 3) = row;
    }
    data.nodes.push_back(std::move(node));
  }
  return data;
}

RigidInertia rigid_inertia(const superelement::Superelement& se) {
  const superelement::InertiaIntegrals& in = se.inertia;
  return {in.mass, in.S_x, in.S_xx.trace() * Matrix3d::Identity() - in.S_xx};
}

}  // namespace flexura::mbs
