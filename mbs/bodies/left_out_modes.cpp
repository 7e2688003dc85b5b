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

// X Lambda^-1 X^T of modes.
class Compliance {
 public:
  Compliance(MatrixXd X, const VectorXd& omega2) : X_(std::move(X)), inverse_(inverse_or_zero(omega2)) {}
  MatrixXd operator()(const MatrixXd& P) const { return X_ * (inverse_.asDiagonal() * (X_.transpose() * P)); }

 private:
  MatrixXd X_;
  VectorXd inverse_;
};

// All modes in the body's frame; empty where it has them all.
std::optional<Compliance> whole(const superelement::Superelement& se, const ModalData& body,
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
  ModeSet all = problem.eigenmodes(MatrixXd(se.n(), 0));
  if (m >= all.omega2.size()) return std::nullopt;
  if (body.frame.cols() > 0) problem.to_held_frame(body.frame, all.Y);
  return Compliance(problem.to_coordinates(all.Y), all.omega2);
}

MatrixXd inertia_of_position(const superelement::InertiaIntegrals& in, Index n) {
  MatrixXd P(n, 12);
  P << in.S_phi.transpose(), in.S_xphi.transpose();
  return P;
}

// int phi_k,b (Phi_i,a) dm, column 9 i + 3 a + b.
MatrixXd inertia_of_deformation(const superelement::InertiaIntegrals& in, const MatrixXd& Y) {
  constexpr int at[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};  // (a, b) of S_phiphi: xx, yy, zz, xy, yz, zx
  MatrixXd out(Y.rows(), 9 * Y.cols());
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const MatrixXd& S = in.S_phiphi[at[a][b]];
      const bool direct = a == b || a == (b + 1) % 3;  // (b, a) is kept
      const MatrixXd of = direct ? MatrixXd(S * Y) : MatrixXd(S.transpose() * Y);
      for (Index i = 0; i < Y.cols(); ++i) out.col(9 * i + 3 * a + b) = of.col(i);
    }
  return out;
}

}  // namespace

std::optional<LeftOutModes> left_out_modes(const superelement::Superelement& se, const ModalData& body,
                                           const std::vector<BodyNode>& nodes) {
  const std::optional<Compliance> all = nodes.empty() ? std::nullopt : whole(se, body, nodes);
  if (!all && body.coupling == Coupling::full) return std::nullopt;
  const Compliance kept(body.Y, body.stiffness);
  const auto answer = [&](const MatrixXd& P) {
    return all ? MatrixXd((*all)(P)-kept(P)) : MatrixXd(MatrixXd::Zero(P.rows(), P.cols()));
  };
  const MatrixXd of_position = inertia_of_position(se.inertia, se.n()),
                 of_deformation = inertia_of_deformation(se.inertia, body.Y);

  LeftOutModes out;
  MatrixXd P(se.n(), 6 * static_cast<Index>(nodes.size()));
  for (std::size_t k = 0; k < nodes.size(); ++k)
    P.middleCols<6>(6 * static_cast<Index>(k)) = nodes[k].rows.transpose();
  out.of_nodes = answer(P);
  P.resize(se.n(), static_cast<Index>(se.load_cases.size()));
  for (std::size_t k = 0; k < se.load_cases.size(); ++k) P.col(static_cast<Index>(k)) = se.load_cases[k].p_se;
  out.of_loads = answer(P);
  out.of_acceleration = -answer(of_position);
  out.of_deformation = -answer(of_deformation);
  if (all && body.second && se.stiffening) {
    const superelement::StiffeningTerms& terms = *se.stiffening;
    const auto add = [&](const auto& K_0) {
      for (const MatrixXd& K : K_0) out.of_stiffening.push_back(-answer(K * body.Y));
    };
    add(terms.K0t);
    add(terms.K0r);
    add(terms.K0omega);
    add(terms.K0F);
    add(terms.K0p);
    // Where no force may put a load case on the body.
    out.of_stiffening.resize(static_cast<std::size_t>(StiffeningLoads(se, nodes).size()),
                             MatrixXd::Zero(se.n(), body.Y.cols()));
  }
  if (body.coupling != Coupling::full) {
    out.dropped_acceleration = -kept(of_position);
    out.dropped_deformation = -kept(of_deformation);
  }
  return out;
}

ParticleAcceleration dropped_inertia(const BodyMotion& motion, int m, Coupling coupling) {
  ParticleAcceleration out(motion, m);
  const ParticleAcceleration known(motion, m, coupling);
  out.c -= known.c;
  out.B -= known.B;
  return out;
}

}  // namespace flexura::mbs
