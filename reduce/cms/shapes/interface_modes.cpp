// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/interface_modes.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "reduce/cms/shapes/constraint_modes.hpp"
#include "reduce/cms/shapes/fixed_interface.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Interior vectors of the soft model in their two parts, by the rows here.
class Condensation {
 public:
  Condensation(const TiedSolver& soft, const TiedSolver& stiff)
      : soft_(soft), stiff_(stiff), rest_(stiff.model().rows_in(soft.model())) {
    std::vector<char> inside(soft.model().n_rows(), 0);
    for (const int i : rest_) inside[i] = 1;
    for (int i = 0; i < soft.model().n_rows(); ++i)
      if (!inside[i]) face_.push_back(i);
    n_face_ = static_cast<Index>(face_.size());
    if (const PartShare* share = soft.model().share()) {
      MatrixXd numbers = MatrixXd::Zero(share->team->size(), 1);
      numbers(share->team->rank()) = static_cast<double>(face_.size());
      numbers = soft.model().sum(std::move(numbers));
      n_face_ = static_cast<Index>(numbers.sum());
      face_before_ = static_cast<Index>(numbers.topRows(share->team->rank()).sum());
    }
  }

  Index n_face() const { return n_face_; }
  /// Without the rigid motions.
  Index n_free() const { return n_face() - (soft_.model().A().rows() - stiff_.model().A().rows()); }

  MatrixXd rest_of(const Eigen::Ref<const MatrixXd>& X) const { return X(rest_, Eigen::all); }

  /// L K^^-1 L^T Z.
  MatrixXd solve(const Eigen::Ref<const MatrixXd>& Z) const {
    MatrixXd X = soft_.solve(Z);
    X(rest_, Eigen::all) -= stiff_.solve(rest_of(Z));
    return X;
  }

  /// L w of the face's part of X.
  MatrixXd extended(MatrixXd X) const {
    X(rest_, Eigen::all).setZero();
    MatrixXd KX;
    soft_.model().multiply_K(X, KX);
    X(rest_, Eigen::all) = -stiff_.solve(rest_of(KX));
    return X;
  }

  /// L^T R on the face, zero elsewhere.
  void condense(MatrixXd& R) const {
    MatrixXd Y = MatrixXd::Zero(R.rows(), R.cols()), KY;
    Y(rest_, Eigen::all) = stiff_.solve(rest_of(R));
    soft_.model().multiply_K(Y, KY);
    R(face_, Eigen::all) -= KY(face_, Eigen::all);
    R(rest_, Eigen::all).setZero();
    soft_.remove_reactions(R);
  }

  /// L w of a basis of all motions without mean.
  MatrixXd whole_space() const {
    const auto n_here = static_cast<Index>(face_.size());
    MatrixXd A = MatrixXd::Zero(soft_.model().A().rows(), n_face_);  // on the faces of all ranks
    A.middleCols(face_before_, n_here) = MatrixXd(soft_.model().A())(Eigen::all, face_);
    A = soft_.model().sum(std::move(A));
    std::vector<Index> rows;  // of the elastic ties; other averages have none of these nodes
    for (Index r = 0; r < A.rows(); ++r)
      if (A.row(r).squaredNorm() > 0.0) rows.push_back(r);
    const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(A(rows, Eigen::all).transpose()).householderQ();
    MatrixXd W = MatrixXd::Zero(soft_.model().n_rows(), n_free());
    W(face_, Eigen::all) = Q.rightCols(n_free()).middleRows(face_before_, n_here);
    return extended(std::move(W));
  }

  /// The constraint modes of the rigid ties on the soft model's interior dofs.
  MatrixXd constraint_modes_on_soft(const MatrixXd& Psi) const {
    const Index n_b = Psi.cols();
    MatrixXd U, P, boundary;
    stiff_.model().expand(Psi, MatrixXd::Identity(n_b, n_b), U);
    soft_.model().motions().gather(U, P, boundary);  // of nodes: puts each displacement in its place
    P = soft_.model().own_rows(std::move(P));
    P(rest_, Eigen::all) = Psi;
    return P;
  }

 private:
  const TiedSolver &soft_, &stiff_;
  std::vector<int> rest_, face_;
  Index n_face_ = 0, face_before_ = 0;  // of all ranks, of those before this one
};

// All pairs of a small space: an iteration has nothing to gain there, and near the space's end round-off is
// all that its new vectors hold.
linalg::EigenPairs all_pairs(const linalg::EigenProblem& problem, const MatrixXd& W) {
  MatrixXd KW, MW;
  problem.multiply_K(W, KW);
  problem.multiply_M(W, MW);
  const MatrixXd K = problem.inner(W, KW), M = problem.inner(W, MW);
  const linalg::DenseEigen eigen =
      linalg::generalized_eigen(0.5 * (K + K.transpose()), 0.5 * (M + M.transpose()));
  linalg::EigenPairs pairs;
  pairs.omega2 = eigen.values;
  pairs.Phi = linalg::times(W, eigen.vectors);
  return pairs;
}

// How much stiffer the interfaces are with the first modes than with all: [k] for k modes.
Eigen::VectorXd stiffness_errors(const MatrixXd& K_bb, const MatrixXd& K_soft, const MatrixXd& R_b,
                                 const MatrixXd& K_bw, const Eigen::VectorXd& omega2) {
  // Rigid motions are held alike on both sides.
  const MatrixXd hold = K_bb.norm() / R_b.squaredNorm() * R_b * R_b.transpose();
  MatrixXd K = K_bb + hold;
  Eigen::VectorXd error(omega2.size() + 1);
  for (Index k = 0; k <= omega2.size(); ++k) {
    error(k) = linalg::generalized_eigen(K, K_soft + hold).values.maxCoeff() - 1.0;
    if (k < omega2.size()) K -= K_bw.col(k) * K_bw.col(k).transpose() / omega2(k);
  }
  return error;
}

}  // namespace

bool has_elastic_ties(const Part& part) {
  return std::any_of(part.interfaces.begin(), part.interfaces.end(),
                     [](const InterfaceSpec& spec) { return spec.tie == Tie::elastic; });
}

Part with_rigid_faces(Part part) {
  for (InterfaceSpec& spec : part.interfaces) {
    if (spec.tie != Tie::elastic) continue;
    if (spec.directions.size() != 6)
      throw std::invalid_argument(
          fmt::format("interface '{}' has an elastic tie and retains {} directions; all six are wanted: the "
                      "interface modes leave out the rigid motions",
                      spec.name, spec.directions.size()));
    spec.tie = Tie::rigid;
  }
  return part;
}

InterfaceModes interface_modes(const TiedSolver& soft, const TiedSolver& stiff, const MatrixXd& Psi,
                               const MatrixXd& K_bb, const InterfaceModesRequest& request,
                               const linalg::Progress& progress) {
  constexpr int kMost = 500;  // to reach an accuracy
  constexpr int kSmall =
      400;  // spaces up to here are treated as a whole, as are those half of which is wanted
  const TiedModel& model = soft.model();
  const Index n_b = K_bb.rows();
  if (request.accuracy > 0.0 && n_b <= 6)
    throw std::invalid_argument(
        "an accuracy of interface modes is one of the static stiffness between interfaces, and the part has "
        "a single one; give their number or a frequency");
  const Condensation condensation(soft, stiff);

  linalg::EigenProblem problem = interior_problem(model);
  problem.n_free = static_cast<int>(condensation.n_free());
  problem.solve = [&](const Eigen::Ref<const MatrixXd>& Z, MatrixXd& X) { X = condensation.solve(Z); };
  problem.condense = [&](MatrixXd& R) { condensation.condense(R); };

  // What loads the faces when the interface dofs move one by one.
  MatrixXd load;
  model.multiply_K(condensation.constraint_modes_on_soft(Psi), load);
  load += model.dense_K_ib();
  const bool measured = n_b > 6;
  const MatrixXd K_soft = measured ? constraint_modes(model, soft).K_bb : MatrixXd();

  InterfaceModes out;
  out.n_face = static_cast<int>(condensation.n_face());
  linalg::EigenRequest wanted{request.count, request.omega_max * request.omega_max, request.tolerance};
  if (request.accuracy > 0.0) wanted = {16, 0.0, request.tolerance};
  const bool small = problem.n_free <= std::max(kSmall, 2 * request.count);
  if (small && request.accuracy > 0.0) wanted.count = problem.n_free;
  for (;; wanted.count = std::min(2 * wanted.count, kMost)) {
    linalg::EigenPairs pairs;
    pairs.Phi.resize(problem.n, 0);
    if (small) {
      pairs = all_pairs(problem, condensation.whole_space());
      linalg::trim(pairs, wanted);
    } else if (wanted.count > 0 || wanted.omega2_max > 0.0) {
      pairs = linalg::block_lanczos(problem, wanted, progress);
    }
    out.K_bw = model.inner(load, pairs.Phi);
    Index kept = pairs.omega2.size();
    if (measured) {
      const Eigen::VectorXd errors =
          stiffness_errors(K_bb, K_soft, model.motions().rigid_b(), out.K_bw, pairs.omega2);
      if (request.accuracy > 0.0) {
        kept = 0;
        while (kept < pairs.omega2.size() && errors(kept) > request.accuracy) ++kept;
        if (errors(kept) > request.accuracy) {
          if (!small && wanted.count < kMost) continue;
          throw std::invalid_argument(
              fmt::format("with {} interface modes the interfaces' static stiffness is within {:.2g} %, not "
                          "{:.2g} %; ask for less, or tie them as an average, which is exact",
                          pairs.omega2.size(), 100.0 * errors(kept), 100.0 * request.accuracy));
        }
        linalg::trim(pairs, {static_cast<int>(kept), 0.0});
        kept = pairs.omega2.size();
      }
      out.stiffness_error = errors(kept);
    }
    // Exactly static in the rest, so that they have no stiffness in common with fixed-interface modes.
    const MatrixXd W = condensation.extended(pairs.Phi);
    MatrixXd KW;
    model.multiply_K(W, KW);
    out.K_ww = model.inner(W, KW);
    out.K_ww = (0.5 * (out.K_ww + out.K_ww.transpose())).eval();
    out.K_bw = model.inner(load, W);
    out.omega2 = pairs.omega2;
    model.expand(W, MatrixXd::Zero(n_b, W.cols()), out.U);
    return out;
  }
}

}  // namespace flexura::reduce
