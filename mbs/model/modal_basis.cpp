// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/modal_basis.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace flexura::mbs {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Modes {
  MatrixXd Y;
  VectorXd omega2;
};

double hz(double omega2) {
  return std::sqrt(omega2) / (2.0 * std::numbers::pi);
}

/// The superelement's matrices scaled to a unit diagonal of M: displacements, rotations and modal coordinates
/// differ in size.
class Scaled {
 public:
  /// `ties` n_se x k: motions along them are held at zero.
  Scaled(const superelement::Superelement& se, const MatrixXd& ties) : se_(se), n_(se.n()), scale_(se.n()) {
    for (int i = 0; i < n_; ++i) {
      if (!(se.M_se(i, i) > 0.0))
        throw std::invalid_argument(fmt::format(
            "superelement \"{}\": M_se has the diagonal entry {} in row {}; every coordinate needs inertia",
            se.name, se.M_se(i, i), i));
      scale_(i) = 1.0 / std::sqrt(se.M_se(i, i));
    }
    M = scale_.asDiagonal() * se.M_se * scale_.asDiagonal();
    K = scale_.asDiagonal() * se.K_se * scale_.asDiagonal();
    R = scale_.cwiseInverse().asDiagonal() * superelement::rigid_motions(se);
    MR_ = M * R;
    Eigen::ColPivHouseholderQR<MatrixXd> qr(MR_);
    qr.setThreshold(1e-9);
    if (n_ <= 6 || qr.rank() != 6)
      throw std::invalid_argument(fmt::format(
          "superelement \"{}\" has {} coordinates that carry {} of the six rigid motions; a flexible "
          "body needs all six and at least one more coordinate (use fidelity = \"rigid\" or interfaces "
          "with more directions)",
          se.name, n_, qr.rank()));
    // The complement of M R: the last n - 6 columns of its orthogonal factor.
    if (ties.cols() == 0) {
      free_ = qr.householderQ() * MatrixXd::Identity(n_, n_).rightCols(n_ - 6);
      return;
    }
    ties_ = to_loads(ties);
    ties_.colwise().normalize();
    free_ = complement(MR_);
    if (free_.cols() == 0)
      throw std::invalid_argument(fmt::format(
          "superelement \"{}\": its rigid links leave no deformation; link fewer interfaces or use "
          "fidelity = \"rigid\"",
          se_.name));
  }

  MatrixXd M, K, R;

  MatrixXd to_coordinates(const MatrixXd& X) const { return scale_.asDiagonal() * X; }
  MatrixXd to_loads(const MatrixXd& P) const { return scale_.asDiagonal() * P; }
  const MatrixXd& free() const { return free_; }

  /// The held directions (scaled as loads) and mean axes for the rigid motions that they leave: what of a
  /// deformation vanishes.
  MatrixXd conditions_of(const MatrixXd& held) const {
    const MatrixXd H = to_loads(held);
    // The null space of H^T R.
    Eigen::FullPivLU<MatrixXd> lu(H.transpose() * R);
    lu.setThreshold(1e-9);
    MatrixXd conditions = H;
    if (const Index left = lu.dimensionOfKernel(); left > 0) {
      conditions.conservativeResize(Eigen::NoChange, H.cols() + left);
      conditions.rightCols(left) = MR_ * lu.kernel();
    }
    return conditions;
  }

  /// Eigenmodes among the vectors orthogonal to `held`, without rigid motions.
  Modes eigenmodes(const MatrixXd& held) const {
    if (held.cols() == 0) return eigenmodes_in(free_);
    const MatrixXd N = complement(conditions_of(held));
    return N.cols() == 0 ? Modes{} : eigenmodes_in(N);
  }

  /// Response modes for the loads, mean axes.
  MatrixXd responses(const MatrixXd& loads, double omega) const {
    const MatrixXd P = free_.transpose() * to_loads(loads);
    MatrixXd A = free_.transpose() * (K - omega * omega * M) * free_;
    A = (0.5 * (A + A.transpose())).eval();
    const Eigen::PartialPivLU<MatrixXd> lu(A);
    if (!(lu.rcond() > 1e-13))
      throw std::invalid_argument(fmt::format(
          "superelement \"{}\": the response frequency {:.6g} Hz is a natural frequency of the free "
          "body; choose another",
          se_.name, omega / (2.0 * std::numbers::pi)));
    return free_ * lu.solve(P);
  }

  /// Takes a rigid motion from each column: none of its momentum is left.
  void to_mean_axes(MatrixXd& S) const { S -= R * (R.transpose() * MR_).ldlt().solve(MR_.transpose() * S); }

  /// Takes a rigid motion from each column: these directions do not move.
  void to_held_frame(const MatrixXd& held, MatrixXd& S) const {
    const MatrixXd H = conditions_of(held);
    if (H.cols() != 6)
      throw std::invalid_argument(fmt::format(
          "superelement \"{}\": {} directions cannot hold a frame; at most six that are independent can",
          se_.name, held.cols()));
    S -= R * Matrix6d(H.transpose() * R).fullPivLu().solve(H.transpose() * S);
  }

  /// Takes a rigid motion from each column: the interface is at rest.
  void to_fixed_interface(int interface, MatrixXd& S) const {
    const superelement::Interface& i = se_.interfaces.at(interface);
    if (i.directions.size() != 6)
      throw std::invalid_argument(fmt::format(
          "superelement \"{}\": interface \"{}\" keeps {} of six directions; a joint-fixed frame needs "
          "all six (or take frame = \"mean_axis\")",
          se_.name, i.name, i.directions.size()));
    const Matrix6d R_i = R.middleRows(i.first_dof, 6);
    S -= R * R_i.fullPivLu().solve(S.middleRows(i.first_dof, 6));
    S.middleRows(i.first_dof, 6).setZero();
  }

  /// Y^T M Y = 1, Y^T K Y = Omega^2 in the span of S; directions that depend on the others are dropped.
  Modes orthonormalised(MatrixXd S) const {
    for (Index k = 0; k < S.cols(); ++k)
      S.col(k) /= std::sqrt(std::max(S.col(k).dot(M * S.col(k)), std::numeric_limits<double>::min()));
    const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(S.transpose() * M * S);
    // Of unit vectors: entries of the Gram matrix are right to 1e-15 n, so what lies below is noise.
    const double least = 1e-12 * gram.eigenvalues().maxCoeff();
    Index dropped = 0;
    while (gram.eigenvalues()(dropped) < least) ++dropped;
    const Index m = S.cols() - dropped;
    const MatrixXd Q = S * gram.eigenvectors().rightCols(m) *
                       gram.eigenvalues().tail(m).cwiseSqrt().cwiseInverse().asDiagonal();
    return eigenmodes_in(Q);
  }

 private:
  /// An orthonormal basis of what is orthogonal to the columns and to the ties.
  MatrixXd complement(const MatrixXd& columns) const {
    MatrixXd all(n_, columns.cols() + ties_.cols());
    if (ties_.cols() > 0)
      all << columns, ties_;
    else
      all = columns;
    for (Index k = 0; k < all.cols(); ++k)
      if (const double length = all.col(k).norm(); length > 0.0) all.col(k) /= length;
    Eigen::ColPivHouseholderQR<MatrixXd> qr(all);
    qr.setThreshold(1e-9);
    return qr.householderQ() * MatrixXd::Identity(n_, n_).rightCols(n_ - qr.rank());
  }

  Modes eigenmodes_in(const MatrixXd& N) const {
    const MatrixXd K_c = N.transpose() * K * N, M_c = N.transpose() * M * N;
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(0.5 * (K_c + K_c.transpose()),
                                                                    0.5 * (M_c + M_c.transpose()));
    if (solver.info() != Eigen::Success)
      throw std::invalid_argument(fmt::format(
          "superelement \"{}\": M_se is not positive definite beside its rigid motions", se_.name));
    Modes modes{N * solver.eigenvectors(), solver.eigenvalues()};
    if (!(modes.omega2(0) > 0.0))
      throw std::invalid_argument(
          fmt::format("superelement \"{}\": K_se has a mode without stiffness beside the six rigid motions "
                      "(omega^2 = {})",
                      se_.name, modes.omega2(0)));
    // A sign that does not depend on the eigensolver: the largest entry is positive.
    for (Index i = 0; i < modes.Y.cols(); ++i) {
      Index k = 0;
      modes.Y.col(i).cwiseAbs().maxCoeff(&k);
      if (modes.Y(k, i) < 0.0) modes.Y.col(i) *= -1.0;
    }
    return modes;
  }

  const superelement::Superelement& se_;
  int n_;
  VectorXd scale_;
  MatrixXd MR_, free_, ties_;
};

FlexibleNode node_of(const BodyNode& at, const MatrixXd& Y, const superelement::StiffeningTerms* terms) {
  const Index m = Y.cols();
  FlexibleNode node;
  node.name = at.name;
  node.p_BoN_B = at.p_BoN_B;
  node.Phi_t = at.rows.topRows<3>() * Y;
  node.Phi_r = at.rows.bottomRows<3>() * Y;
  if (!terms || !at.is_on_interfaces) return node;
  MatrixXd second = MatrixXd::Zero(6 * m, m);
  for (std::size_t dof = 0; dof < terms->K0F.size(); ++dof) {
    const auto share = at.rows.col(static_cast<Index>(dof));
    if (share.isZero(0.0)) continue;
    const MatrixXd K0F = Y.transpose() * terms->K0F[dof] * Y;
    for (int k = 0; k < 6; ++k)
      if (share(k) != 0.0) second.middleRows(k * m, m) -= share(k) * K0F;
  }
  if (!second.isZero(0.0)) node.second = std::move(second);
  return node;
}

/// All of the nodes' ties side by side.
MatrixXd ties_of(const superelement::Superelement& se, const std::vector<BodyNode>& nodes) {
  MatrixXd ties(se.n(), 0);
  for (const BodyNode& node : nodes) {
    if (node.ties.cols() == 0) continue;
    ties.conservativeResize(Eigen::NoChange, ties.cols() + node.ties.cols());
    ties.rightCols(node.ties.cols()) = node.ties;
  }
  return ties;
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

SecondOrderIntegrals second_order_integrals(const superelement::StiffeningTerms& terms, const MatrixXd& Y) {
  const Index m = Y.cols();
  const auto in_modes = [&](const MatrixXd& K0) { return MatrixXd(Y.transpose() * K0 * Y); };
  SecondOrderIntegrals out;
  out.t.resize(3 * m, m);
  out.x.resize(9 * m, m);
  MatrixXd trace = MatrixXd::Zero(m, m);
  for (int a = 0; a < 3; ++a) {
    out.t.middleRows(a * m, m) = in_modes(terms.K0t[a]);
    out.x.middleRows(4 * a * m, m) = in_modes(terms.K0omega[a]);
    trace -= 0.5 * out.x.middleRows(4 * a * m, m);
  }
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;  // K0omega holds xy, yz, zx behind xx, yy, zz
    out.x.middleRows(4 * a * m, m) += trace;
    const MatrixXd sum = in_modes(terms.K0omega[3 + a]), difference = in_modes(terms.K0r[c]);
    out.x.middleRows((3 * a + b) * m, m) = 0.5 * (sum + difference);
    out.x.middleRows((3 * b + a) * m, m) = 0.5 * (sum - difference);
  }
  return out;
}

MatrixXd interface_loads(const superelement::Superelement& se, int interface, const Vector3d& offset) {
  return node_loads(interface_node(se, interface), offset);
}

MatrixXd interface_loads(const superelement::Superelement& se, const std::vector<int>& interfaces) {
  MatrixXd P(se.n(), 6 * interfaces.size());
  for (std::size_t k = 0; k < interfaces.size(); ++k)
    P.middleCols<6>(6 * static_cast<Index>(k)) = interface_loads(se, interfaces[k]);
  return P;
}

ModalData modal_data(const superelement::Superelement& se, const BasisOptions& options, BasisReport* report) {
  if (options.stiffening && !se.stiffening)
    throw std::invalid_argument(
        fmt::format("superelement \"{}\" has no geometric stiffening terms; reduce the part again with "
                    "stiffening = true, or "
                    "use fidelity = \"modal\"",
                    se.name));
  const Scaled scaled(se, ties_of(se, options.nodes));
  Modes modes = scaled.eigenmodes(options.held);
  const int available = static_cast<int>(modes.omega2.size());
  int kept = 0;
  while (kept < available && kept < options.modes && hz(modes.omega2(kept)) <= options.max_frequency) ++kept;
  const bool responses = options.loads.cols() > 0 && (kept < available || options.held.cols() > 0);
  if (kept == 0 && !responses)
    throw std::invalid_argument(fmt::format(
        "superelement \"{}\": no mode is left (the first one of {} has {:.6g} Hz); keep one or use "
        "fidelity = \"rigid\"",
        se.name, available, available > 0 ? hz(modes.omega2(0)) : 0.0));
  const double first_dropped = kept < available ? hz(modes.omega2(kept)) : 0.0;
  std::vector<double> eigen_hz;
  for (int i = 0; i < kept; ++i) eigen_hz.push_back(hz(modes.omega2(i)));

  const bool free_eigenmodes_alone =
      options.held.cols() == 0 && !responses && options.fixed_interface < 0 && options.frame.cols() == 0;
  if (free_eigenmodes_alone) {
    modes.Y = modes.Y.leftCols(kept).eval();
    modes.omega2 = modes.omega2.head(kept).eval();
  } else {
    MatrixXd S(se.n(), kept + (responses ? options.loads.cols() : 0));
    S.leftCols(kept) = modes.Y.leftCols(kept);
    if (responses)
      S.rightCols(options.loads.cols()) =
          scaled.responses(options.loads, 2.0 * std::numbers::pi * options.response_frequency);
    // Mean axes first: what is dependent there is, whatever frame follows.
    scaled.to_mean_axes(S);
    modes = scaled.orthonormalised(std::move(S));
    if (options.fixed_interface >= 0) {
      scaled.to_fixed_interface(options.fixed_interface, modes.Y);
      modes = scaled.orthonormalised(std::move(modes.Y));
    } else if (options.frame.cols() > 0) {
      scaled.to_held_frame(options.frame, modes.Y);
      modes = scaled.orthonormalised(std::move(modes.Y));
    }
  }
  const int m = static_cast<int>(modes.omega2.size());
  if (report)
    *report = {available,     kept,    m - kept, hz(modes.omega2(0)), hz(modes.omega2(m - 1)),
               first_dropped, eigen_hz};

  ModalData data;
  data.Y = scaled.to_coordinates(modes.Y);
  data.stiffness = modes.omega2;
  data.inertia = transform(se.inertia, data.Y);
  data.coupling = options.coupling;
  DampingLaw law = options.damping_law;
  if (options.damping) law.ratio = options.damping;
  // Of a general D_se the modes keep what acts within each mode.
  const VectorXd of_superelement = se.D_se.size() > 0
                                       ? VectorXd((data.Y.transpose() * se.D_se * data.Y).diagonal())
                                       : VectorXd(2.0 * se.modal_damping * data.stiffness.cwiseSqrt());
  data.damping = modal_damping(law, data.stiffness, of_superelement);
  const superelement::StiffeningTerms* terms = options.stiffening ? &*se.stiffening : nullptr;
  if (terms) data.second = second_order_integrals(*terms, data.Y);
  for (const BodyNode& node : interface_nodes(se)) data.nodes.push_back(node_of(node, data.Y, terms));
  for (const BodyNode& node : options.nodes) data.nodes.push_back(node_of(node, data.Y, terms));
  return data;
}

RigidInertia rigid_inertia(const superelement::Superelement& se) {
  const superelement::InertiaIntegrals& in = se.inertia;
  return {in.mass, in.S_x, in.S_xx.trace() * Matrix3d::Identity() - in.S_xx};
}

}  // namespace flexura::mbs
