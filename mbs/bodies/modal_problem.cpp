// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/modal_problem.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "mbs/base/math/spatial.hpp"

namespace flexura::mbs {

using Eigen::Index;
using Eigen::MatrixXd;

ModalProblem::ModalProblem(const superelement::Superelement& se, const MatrixXd& ties)
    : se_(se), n_(se.n()), scale_(se.n()) {
  for (int i = 0; i < n_; ++i) {
    if (!(se.M_se(i, i) > 0.0))
      throw std::invalid_argument(fmt::format(
          "superelement \"{}\": M_se has the diagonal entry {} in row {}; every coordinate needs inertia",
          se.name, se.M_se(i, i), i));
    scale_(i) = 1.0 / std::sqrt(se.M_se(i, i));
  }
  M_ = scale_.asDiagonal() * se.M_se * scale_.asDiagonal();
  K_ = scale_.asDiagonal() * se.K_se * scale_.asDiagonal();
  R_ = scale_.cwiseInverse().asDiagonal() * superelement::rigid_motions(se);
  // Displacements and rotations count alike, whatever the body's size and the units: only the space that they span is used.
  for (Index k = 0; k < R_.cols(); ++k)
    if (const double length = R_.col(k).norm(); length > 0.0) R_.col(k) /= length;
  MR_ = M_ * R_;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(MR_);
  qr.setThreshold(1e-9);
  if (n_ <= 6 || qr.rank() != 6)
    throw std::invalid_argument(fmt::format(
        "superelement \"{}\" has {} coordinates that carry {} of the six rigid motions; a flexible "
        "body needs all six and at least one more coordinate ({})",
        se.name, n_, qr.rank(),
        se.created_by.starts_with("flexura import")
            ? "it is the rigid one of an import: flexura simulate --reduce makes one that deforms of the "
              "part file beside "
              "it; or use fidelity = \"rigid\""
            : "use fidelity = \"rigid\" or interfaces with more directions"));
  if (ties.cols() == 0) {
    // The complement of M R: the last n - 6 columns of its orthogonal factor.
    free_ = qr.householderQ() * MatrixXd::Identity(n_, n_).rightCols(n_ - 6);
    return;
  }
  ties_ = to_loads(ties);
  ties_.colwise().normalize();
  free_ = complement(MR_);
  if (free_.cols() == 0)
    throw std::invalid_argument(
        fmt::format("superelement \"{}\": its rigid links leave no deformation; link fewer interfaces or use "
                    "fidelity = \"rigid\"",
                    se_.name));
}

namespace {
// Of the highest omega^2: what may be none.  Constraint modes leave 1e-12 of the stiffness, dense solutions n times round-off.
constexpr double kNoStiffness = 1e-13;
}  // namespace

// The held directions (scaled as loads) and mean axes for the rigid motions that they leave: what of a
// deformation vanishes.
MatrixXd ModalProblem::conditions_of(const MatrixXd& held) const {
  MatrixXd H = to_loads(held);
  for (Index k = 0; k < H.cols(); ++k)
    if (const double length = H.col(k).norm(); length > 0.0) H.col(k) /= length;
  // The null space of H^T R.
  Eigen::FullPivLU<MatrixXd> lu(H.transpose() * R_);
  lu.setThreshold(1e-9);
  MatrixXd conditions = H;
  if (const Index left = lu.dimensionOfKernel(); left > 0) {
    conditions.conservativeResize(Eigen::NoChange, H.cols() + left);
    conditions.rightCols(left) = MR_ * lu.kernel();
  }
  return conditions;
}

// An orthonormal basis of what is orthogonal to the columns and to the ties.
MatrixXd ModalProblem::complement(const MatrixXd& columns) const {
  MatrixXd all(n_, columns.cols() + ties_.cols());
  all.leftCols(columns.cols()) = columns;
  if (ties_.cols() > 0) all.rightCols(ties_.cols()) = ties_;
  for (Index k = 0; k < all.cols(); ++k)
    if (const double length = all.col(k).norm(); length > 0.0) all.col(k) /= length;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(all);
  qr.setThreshold(1e-9);
  return qr.householderQ() * MatrixXd::Identity(n_, n_).rightCols(n_ - qr.rank());
}

ModeSet ModalProblem::eigenmodes(const MatrixXd& held) const {
  if (held.cols() == 0) return eigenmodes_in(free_);
  const MatrixXd N = complement(conditions_of(held));
  return N.cols() == 0 ? ModeSet{MatrixXd(n_, 0), Eigen::VectorXd(0)} : eigenmodes_in(N);
}

MatrixXd ModalProblem::responses(const MatrixXd& loads, double omega) const {
  const MatrixXd P = free_.transpose() * to_loads(loads);
  MatrixXd A = free_.transpose() * (K_ - omega * omega * M_) * free_;
  A = (0.5 * (A + A.transpose())).eval();
  if (omega > 0.0) {
    // So near to a resonance what the loads do beside its mode is a thousandth of it and gets lost.
    constexpr double kNear = 1e-3;
    const Eigen::VectorXd omega2 = eigenmodes_in(free_).omega2;
    for (Index k = 0; k < omega2.size(); ++k)
      if (std::abs(omega / std::sqrt(omega2(k)) - 1.0) < kNear)
        throw BasisError("response_frequency",
                         fmt::format("superelement \"{}\": {:.6g} Hz lies within 0.1 % of the free body's "
                                     "natural frequency {:.6g} Hz, so that all response modes would be that "
                                     "mode; choose another",
                                     se_.name, omega / (2.0 * std::numbers::pi),
                                     std::sqrt(omega2(k)) / (2.0 * std::numbers::pi)));
  }
  // A load on a motion without strain has no static answer: like the rigid ones it is left to inertia.
  if (!(omega > 0.0)) {
    const ModeSet modes = eigenmodes_in(free_);
    Index still = 0;
    while (still < modes.omega2.size() && modes.omega2(still) == 0.0) ++still;
    if (still > 0) {
      const Index k = modes.omega2.size() - still;
      return modes.Y.rightCols(k) * modes.omega2.tail(k).cwiseInverse().asDiagonal() *
             (modes.Y.rightCols(k).transpose() * to_loads(loads));
    }
  }
  const Eigen::PartialPivLU<MatrixXd> lu(A);
  return free_ * lu.solve(P);
}

void ModalProblem::to_mean_axes(MatrixXd& S) const {
  S -= R_ * (R_.transpose() * MR_).ldlt().solve(MR_.transpose() * S);
}

void ModalProblem::to_held_frame(const MatrixXd& held, MatrixXd& S) const {
  const MatrixXd H = conditions_of(held);
  if (H.cols() != 6)
    throw std::invalid_argument(fmt::format(
        "superelement \"{}\": {} directions cannot hold a frame; at most six that are independent can",
        se_.name, held.cols()));
  S -= R_ * Matrix6d(H.transpose() * R_).fullPivLu().solve(H.transpose() * S);
}

void ModalProblem::to_fixed_interface(int interface, MatrixXd& S) const {
  const superelement::Interface& i = se_.interfaces.at(interface);
  if (i.directions.size() + i.following.size() + i.free.size() != 6)
    throw std::invalid_argument(fmt::format(
        "superelement \"{}\": interface \"{}\" keeps {} of six directions; a joint-fixed frame needs "
        "all six (or take frame = \"mean_axis\")",
        se_.name, i.name, i.directions.size()));
  const MatrixXd rows = superelement::interface_motion(se_, i);
  const Matrix6d R_i = rows * R_;
  S -= R_ * R_i.fullPivLu().solve(rows * S);
  S.middleRows(i.first_dof, static_cast<Index>(i.directions.size())).setZero();
}

ModeSet ModalProblem::orthonormalised(MatrixXd S) const {
  for (Index k = 0; k < S.cols(); ++k)
    S.col(k) /= std::sqrt(std::max(S.col(k).dot(M_ * S.col(k)), std::numeric_limits<double>::min()));
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(S.transpose() * M_ * S);
  // Of unit vectors: entries of the Gram matrix are right to 1e-15 n, so what lies below is noise.
  const double least = 1e-12 * gram.eigenvalues().maxCoeff();
  Index dropped = 0;
  while (gram.eigenvalues()(dropped) < least) ++dropped;
  const Index m = S.cols() - dropped;
  const MatrixXd Q = S * gram.eigenvectors().rightCols(m) *
                     gram.eigenvalues().tail(m).cwiseSqrt().cwiseInverse().asDiagonal();
  return eigenmodes_in(Q);
}

ModesWithin ModalProblem::eigenmodes_within(const ModeSet& basis, const MatrixXd& held) const {
  const Index m = basis.Y.cols();
  MatrixXd S = basis.Y;
  to_mean_axes(S);
  MatrixXd G = S.transpose() * M_ * S;
  G = (0.5 * (G + G.transpose())).eval();
  ModesWithin out{MatrixXd(m, m), Eigen::VectorXd(m)};
  Index k = 0;
  if (held.cols() > 0) {
    MatrixXd V(n_, m + R_.cols());
    V << S, R_;
    // What of V's combinations the condition leaves.
    const Eigen::ColPivHouseholderQR<MatrixXd> conditions = [&] {
      MatrixXd rows = V.transpose() * conditions_of(held);
      for (Index j = 0; j < rows.cols(); ++j)
        if (const double length = rows.col(j).norm(); length > 0.0) rows.col(j) /= length;
      Eigen::ColPivHouseholderQR<MatrixXd> qr(rows.rows(), rows.cols());
      qr.setThreshold(1e-9);
      return qr.compute(rows);
    }();
    const Index left = V.cols() - conditions.rank();
    const MatrixXd N = conditions.householderQ() * MatrixXd::Identity(V.cols(), V.cols()).rightCols(left);
    k = std::min(left, m);
    if (k > 0) {
      const ModeSet modes = eigenmodes_in(V * N);
      MatrixXd X = modes.Y.leftCols(k);
      to_mean_axes(X);
      out.C.leftCols(k) = G.ldlt().solve(S.transpose() * (M_ * X));
      out.omega2.head(k) = modes.omega2.head(k);
    }
  }
  if (k < m) {
    const Eigen::HouseholderQR<MatrixXd> qr(G * out.C.leftCols(k));
    const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(m, m).rightCols(m - k);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> rest(
        Q.transpose() * basis.omega2.asDiagonal() * Q, Q.transpose() * G * Q);
    out.C.rightCols(m - k) = Q * rest.eigenvectors();
    out.omega2.tail(m - k) = rest.eigenvalues();
  }
  return out;
}

ModeSet ModalProblem::eigenmodes_in(const MatrixXd& N) const {
  const MatrixXd K_c = N.transpose() * K_ * N, M_c = N.transpose() * M_ * N;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(0.5 * (K_c + K_c.transpose()),
                                                                  0.5 * (M_c + M_c.transpose()));
  if (solver.info() != Eigen::Success)
    throw std::invalid_argument(
        fmt::format("superelement \"{}\": M_se is not positive definite beside its rigid motions", se_.name));
  ModeSet modes{N * solver.eigenvectors(), solver.eigenvalues()};
  // A body that hinges within itself has motions without strain, 0 to round-off of the highest.
  const double noise = kNoStiffness * modes.omega2(modes.omega2.size() - 1);
  if (!(modes.omega2(0) >= -noise))
    throw std::invalid_argument(
        fmt::format("superelement \"{}\": K_se has a motion of negative stiffness beside the six rigid ones "
                    "(omega^2 = {}); reduce the part again, without loads that make it buckle",
                    se_.name, modes.omega2(0)));
  modes.omega2 = (modes.omega2.array() <= noise).select(0.0, modes.omega2);
  // A sign that does not depend on the eigensolver: the largest entry is positive.
  for (Index i = 0; i < modes.Y.cols(); ++i) {
    Index k = 0;
    modes.Y.col(i).cwiseAbs().maxCoeff(&k);
    if (modes.Y(k, i) < 0.0) modes.Y.col(i) *= -1.0;
  }
  return modes;
}

}  // namespace flexura::mbs
