// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/left_out_modes.hpp"

#include "mbs/bodies/modal_problem.hpp"

namespace flexura::mbs {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

VectorXd inverse_or_zero(const VectorXd& omega2) {
  return omega2.unaryExpr([](double x) { return x > 0.0 ? 1.0 / x : 0.0; });
}

}  // namespace

std::optional<LeftOutModes> left_out_modes(const superelement::Superelement& se, const ModalData& body,
                                           const std::vector<BodyNode>& nodes) {
  MatrixXd ties(se.n(), 0);
  for (const BodyNode& node : nodes) {
    if (node.ties.cols() == 0) continue;
    ties.conservativeResize(Eigen::NoChange, ties.cols() + node.ties.cols());
    ties.rightCols(node.ties.cols()) = node.ties;
  }
  const Index m = body.Y.cols();
  if (m + 6 + ties.cols() >= se.n()) return std::nullopt;
  const ModalProblem problem(se, ties);
  const ModeSet all = problem.eigenmodes(MatrixXd(se.n(), 0));
  if (m >= all.omega2.size()) return std::nullopt;
  const MatrixXd X = problem.to_coordinates(all.Y);
  const auto answer = [&](const MatrixXd& P) {
    return MatrixXd(X * (inverse_or_zero(all.omega2).asDiagonal() * (X.transpose() * P)) -
                    body.Y * (inverse_or_zero(body.stiffness).asDiagonal() * (body.Y.transpose() * P)));
  };

  LeftOutModes out;
  MatrixXd P(se.n(), 6 * static_cast<Index>(nodes.size()));
  for (std::size_t k = 0; k < nodes.size(); ++k)
    P.middleCols<6>(6 * static_cast<Index>(k)) = nodes[k].rows.transpose();
  out.of_nodes = answer(P);
  P.resize(se.n(), static_cast<Index>(se.load_cases.size()));
  for (std::size_t k = 0; k < se.load_cases.size(); ++k) P.col(static_cast<Index>(k)) = se.load_cases[k].p_se;
  out.of_loads = answer(P);
  P.resize(se.n(), 12);
  P << -se.inertia.S_phi.transpose(), -se.inertia.S_xphi.transpose();
  out.of_acceleration = answer(P);
  // int phi_k,b (Phi_i,a) dm for all modes i, (a, b) of S_phiphi as xx, yy, zz, xy, yz, zx.
  constexpr int at[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  out.of_deformation.resize(se.n(), 9 * m);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const MatrixXd& S = se.inertia.S_phiphi[at[a][b]];
      const bool direct = a == b || a == (b + 1) % 3;  // (b, a) is kept
      const MatrixXd of = answer(direct ? MatrixXd(-(S * body.Y)) : MatrixXd(-(S.transpose() * body.Y)));
      for (Index i = 0; i < m; ++i) out.of_deformation.col(9 * i + 3 * a + b) = of.col(i);
    }
  return out;
}

}  // namespace flexura::mbs
