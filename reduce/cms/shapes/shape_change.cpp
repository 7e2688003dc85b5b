// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/shape_change.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Mass-orthonormal combinations of the vectors, by Gram and Schmidt, twice.
MatrixXd mass_orthonormal(const MatrixXd& M, std::vector<int>& dropped) {
  const Index m = M.rows();
  MatrixXd Q(m, m);
  Index rank = 0;
  for (Index j = 0; j < m; ++j) {
    VectorXd q = VectorXd::Unit(m, j);
    const double length = std::sqrt(M(j, j));
    for (int pass = 0; pass < 2; ++pass) q -= Q.leftCols(rank) * (Q.leftCols(rank).transpose() * (M * q));
    const double rest = std::sqrt(std::max(q.dot(M * q), 0.0));
    if (!(rest > kDependent * length)) {
      dropped.push_back(static_cast<int>(j));
      continue;
    }
    Q.col(rank++) = q / rest;
  }
  return Q.leftCols(rank);
}

}  // namespace

std::vector<int> independent_dofs(const MatrixXd& M, const MatrixXd& B) {
  std::vector<int> dropped, own;
  const MatrixXd B_Q = B * mass_orthonormal(M, dropped);
  // The most independent first: a dof that hardly moves by itself would need huge shapes for a unit of it.
  MatrixXd left = B_Q;
  for (Index b = 0; b < left.rows(); ++b)
    if (const double size = left.row(b).norm(); size > 0.0) left.row(b) /= size;
  for (Index pivot = 0; left.rows() > 0 && left.rowwise().norm().maxCoeff(&pivot) > kSameMotion;) {
    own.push_back(static_cast<int>(pivot));
    const VectorXd q = left.row(pivot).normalized();
    for (int pass = 0; pass < 2; ++pass) left -= (left * q).eval() * q.transpose();
    left.row(pivot).setZero();
  }
  std::ranges::sort(own);
  return own;
}

std::vector<std::string> let_others_follow(Reduction& r, const MatrixXd& B, const std::vector<int>& own) {
  static constexpr const char* kNames[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};
  std::vector<std::string> names;
  int next = 0;
  for (ReducedInterface& interface : r.interfaces) {
    std::vector<int> kept, rows;
    for (std::size_t k = 0; k < interface.directions.size(); ++k) {
      const int row = interface.first_dof + static_cast<int>(k), d = interface.directions[k];
      if (std::ranges::binary_search(own, row)) {
        kept.push_back(d);
        continue;
      }
      rows.push_back(row);
      interface.following.push_back(d);
      names.push_back(interface.name + " " + kNames[d]);
    }
    interface.directions = std::move(kept);
    interface.follow = B(rows, Eigen::all);
    interface.first_dof = next;
    next += static_cast<int>(interface.directions.size());
  }
  r.n_b = next;
  return names;
}

CanonicalShapes canonical_shapes(const MatrixXd& K, const MatrixXd& M, const MatrixXd& B) {
  const Index n_b = B.rows();
  CanonicalShapes out;
  const MatrixXd Q = mass_orthonormal(M, out.dropped);
  const Index rank = Q.cols();
  const MatrixXd K_Q = Q.transpose() * K * Q;
  MatrixXd B_Q = B * Q;
  // Displacements and rotations are brought to one size.
  const VectorXd size = B_Q.rowwise().norm();
  for (Index b = 0; b < n_b; ++b)
    if (size(b) > 0.0) B_Q.row(b) /= size(b);
  Eigen::ColPivHouseholderQR<MatrixXd> qr(B_Q.transpose());
  qr.setThreshold(kSameMotion);  // entries are of size one
  if (qr.rank() < n_b)
    throw std::invalid_argument(
        fmt::format("the modes that are kept move only {} of the {} interface dofs independently; keep more",
                    qr.rank(), n_b));
  const MatrixXd H = qr.householderQ() * MatrixXd::Identity(rank, rank);
  const MatrixXd N = H.rightCols(rank - n_b);
  linalg::DenseEigen ritz{Eigen::VectorXd(0), MatrixXd(0, 0)};
  if (N.cols() > 0) ritz = linalg::symmetric_eigen(N.transpose() * K_Q * N);
  const MatrixXd E = N * ritz.vectors;
  const MatrixXd inverse = qr.solve(MatrixXd::Identity(rank, rank));  // (B^T)^+, n_b x rank
  MatrixXd P = inverse.transpose() * size.cwiseInverse().asDiagonal();
  P -= E * ritz.values.cwiseInverse().asDiagonal() * (E.transpose() * (K_Q * P));
  out.omega2 = ritz.values;
  out.Y.resize(M.rows(), rank);
  out.Y << Q * P, Q * E;
  return out;
}

void change_shapes(Reduction& r, const CanonicalShapes& shapes) {
  const MatrixXd& Y = shapes.Y;
  const auto congruent = [&](MatrixXd& A) {
    if (A.size() == 0) return;
    const MatrixXd Z = Y.transpose() * A * Y;
    A = 0.5 * (Z + Z.transpose());
  };
  congruent(r.K_se);
  congruent(r.M_se);
  congruent(r.D_se);
  r.omega2 = shapes.omega2;
  r.n_q = static_cast<int>(shapes.omega2.size());
  for (ReducedInterface& interface : r.interfaces) {
    if (!interface.free.empty()) interface.free_motion = (interface.free_motion * Y).eval();
    if (interface.following.empty()) continue;
    interface.follow = (interface.follow * Y).eval();
    interface.follow.rightCols(r.n_q).setZero();  // what moves no dof does not move what follows dofs
  }
  r.K_se.topRightCorner(r.n_b, r.n_q).setZero();
  r.K_se.bottomLeftCorner(r.n_q, r.n_b).setZero();
  r.K_se.bottomRightCorner(r.n_q, r.n_q) = MatrixXd(shapes.omega2.asDiagonal());
  // Six motions that hold the body are its rigid motions: what stands there is round-off.
  if (r.n_b == 6) r.K_se.topLeftCorner(6, 6).setZero();
  r.inertia.S_phi = (r.inertia.S_phi * Y).eval();
  r.inertia.S_xphi = (r.inertia.S_xphi * Y).eval();
  for (MatrixXd& S : r.inertia.S_phiphi) S = (Y.transpose() * S * Y).eval();  // (a, b) is not symmetric
  if (r.stiffening) {
    for (MatrixXd& A : r.stiffening->K0t) congruent(A);
    for (MatrixXd& A : r.stiffening->K0r) congruent(A);
    for (MatrixXd& A : r.stiffening->K0omega) congruent(A);
    for (MatrixXd& A : r.stiffening->K0F) congruent(A);
    for (MatrixXd& A : r.stiffening->K0p) congruent(A);
  }
  for (ReducedLoad& load : r.loads) {
    load.p_se = (Y.transpose() * load.p_se).eval();
    if (load.moment.cols() > 0) load.moment = (load.moment * Y).eval();
  }
  if (r.stress_modes.size() > 0) r.stress_modes = linalg::times(r.stress_modes, Y);
  if (r.shapes.size() > 0) r.shapes = (r.shapes * Y.cast<float>()).eval();
  if (r.bars)
    r.bars->nodes = linalg::times(r.bars->nodes, Y), r.bars->points = linalg::times(r.bars->points, Y);
  if (r.nodes) r.nodes->T = linalg::times(r.nodes->T, Y);
  r.dropped.resize(0, 0);
  r.dropped_growth.resize(0, 0);
  r.omega2_dropped = 0.0;
}

StruckModes strike_modes(Reduction& r, const std::vector<int>& numbers) {
  const linalg::DenseEigen modes = linalg::generalized_eigen(r.K_se, r.M_se);
  StruckModes out;
  std::vector<char> gone(r.n(), 0);
  for (const int number : numbers) {
    if (number >= 1 && number <= 6)
      throw std::invalid_argument(
          fmt::format("mode {} is a rigid one (1 to 6); rigid modes cannot be struck out", number));
    if (number < 1 || number > r.n())
      throw std::invalid_argument(
          fmt::format("there is no mode {} to strike out; the superelement has {}", number, r.n()));
    if (gone[number - 1]) continue;
    gone[number - 1] = 1;
    out.frequencies.push_back(std::sqrt(std::max(modes.values(number - 1), 0.0)) / (2.0 * std::numbers::pi));
  }
  std::vector<int> kept;
  for (int k = 0; k < r.n(); ++k)
    if (!gone[k]) kept.push_back(k);
  if (r.mesh) {
    std::vector<MeshShare::Mode> left;
    for (std::size_t k = 0; k < r.mesh->modes.size(); ++k)
      if (!gone[6 + k]) left.push_back(r.mesh->modes[k]);
    r.mesh->modes = std::move(left);
  }
  const MatrixXd Z = modes.vectors(Eigen::all, kept);
  CanonicalShapes shapes =
      canonical_shapes(Z.transpose() * r.K_se * Z, Z.transpose() * r.M_se * Z, Z.topRows(r.n_b));
  shapes.Y = (Z * shapes.Y).eval();
  out.Y = shapes.Y;
  // Rigid motions are held alike before and after, so that both stiffnesses can be compared.
  const MatrixXd before = r.K_se.topLeftCorner(r.n_b, r.n_b);
  const MatrixXd R = modes.vectors.topLeftCorner(r.n_b, 6);
  change_shapes(r, shapes);
  if (!(before.norm() > 0.0)) return out;  // one interface, which nothing else holds: no static stiffness
  const MatrixXd hold = before.norm() / R.squaredNorm() * R * R.transpose();
  out.interface_stiffer =
      linalg::generalized_eigen(r.K_se.topLeftCorner(r.n_b, r.n_b) + hold, before + hold).values.maxCoeff() -
      1.0;
  return out;
}

}  // namespace flexura::reduce
