// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/constraint_modes.hpp"

#include <algorithm>
#include <limits>

#include "reduce/assembly/ties/pieces.hpp"
#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double kWorthAsking = 1e-8;  // a residual below needs no excuse

}  // namespace

RigidProjection rigid_projection(const TiedModel& model) {
  std::vector<char> is_rotation;
  for (int k = 0; k < model.n_interfaces(); ++k)
    for (const int direction : model.numbering().directions(k)) is_rotation.push_back(direction >= 3);
  return {model.motions().rigid_b(), is_rotation};
}

void part_by_pieces(const Part& part, const TiedModel& model, MatrixXd& K_bb) {
  if (model.share()) return;
  const Pieces pieces = pieces_of(part);
  if (pieces.sizes.size() < 2) return;
  const MatrixXd R_b = model.motions().rigid_b();
  std::vector<std::vector<int>> dofs(pieces.sizes.size());
  std::vector<char> is_rotation;
  for (int k = 0; k < model.n_interfaces(); ++k) {
    const int piece = pieces.of_node[static_cast<std::size_t>(
        part.interfaces[static_cast<std::size_t>(k)].set.nodes.front())];
    for (const int direction : model.numbering().directions(k)) {
      if (piece >= 0) dofs[static_cast<std::size_t>(piece)].push_back(static_cast<int>(is_rotation.size()));
      is_rotation.push_back(direction >= 3);
    }
  }
  MatrixXd K = MatrixXd::Zero(K_bb.rows(), K_bb.cols());
  for (const std::vector<int>& own : dofs) {
    std::vector<char> turns;
    for (const int b : own) turns.push_back(is_rotation[static_cast<std::size_t>(b)]);
    if (own.size() >= 6)
      K(own, own) = RigidProjection(R_b(own, Eigen::all), turns).strain_free(K_bb(own, own));
  }
  K_bb = K;
}

ConstraintModes constraint_modes(const TiedModel& model, const TiedSolver& solver) {
  const auto& averaged = model.averaged_dofs();
  const Index n_a = static_cast<Index>(averaged.size());
  const MatrixXd K_ib = model.dense_K_ib();
  MatrixXd g = MatrixXd::Zero(n_a, model.n_b());
  for (Index r = 0; r < n_a; ++r) g(r, averaged[r]) = 1.0;
  TiedSolver::Solution solution = solver.solve_refined(-K_ib, g);
  ConstraintModes modes{std::move(solution.U), model.K_bb(), 0.0};
  MatrixXd K_Psi;
  model.multiply_K(modes.Psi, K_Psi);
  MatrixXd reaction = MatrixXd::Zero(model.n_rows(), model.n_b());
  if (n_a > 0) reaction = model.A().transpose() * solution.mu;
  const double scale = model.norm(K_ib) + model.norm(reaction);
  const double open = model.norm(K_Psi + K_ib + reaction);
  if (scale > 0.0) modes.residual = open / scale;
  if (modes.residual > kWorthAsking) {
    // Where all static shapes are rigid motions, of averages for one, K_ib and the reactions are round-off themselves:
    // eps |K| |Psi| is what rounding the shapes' entries does, and nothing below a few of it can be judged.
    MatrixXd magnitudes;
    model.multiply_magnitudes(modes.Psi, magnitudes);
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * model.norm(magnitudes);
    modes.residual = open <= rounding ? 0.0 : open / std::max(scale, rounding);
  }
  modes.K_bb += model.inner(K_ib, modes.Psi);
  for (Index r = 0; r < n_a; ++r) modes.K_bb.row(averaged[r]) -= solution.mu.row(r);
  modes.K_bb = (0.5 * (modes.K_bb + modes.K_bb.transpose())).eval();
  const MatrixXd R_b = model.motions().rigid_b(), R_i = model.own_rows(model.motions().rigid_i());
  const RigidProjection rigid = rigid_projection(model);
  const MatrixXd off = R_i - modes.Psi * R_b;
  for (Index c = 0; c < 6; ++c)
    modes.rigid_error = std::max(modes.rigid_error, model.norm(off.col(c)) / model.norm(R_i.col(c)));
  if (model.n_b() > 6) modes.rigid_strain = (modes.K_bb * R_b).norm() / (modes.K_bb.norm() * R_b.norm());
  modes.Psi = rigid.corrected(modes.Psi, R_i);
  modes.K_bb = rigid.strain_free(modes.K_bb);
  return modes;
}

}  // namespace flexura::reduce
