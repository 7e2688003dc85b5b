// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/errors/judged_states.hpp"

#include <numeric>
#include <vector>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

void share_motions(const TiedModel& model, JudgedMotions& motions) {
  MatrixXd numbers(1 + motions.states.lambda.size(), 1);
  numbers << static_cast<double>(motions.n_modes), motions.states.lambda;
  model.share(numbers);
  model.share(motions.states.Y);
  motions.n_modes = static_cast<int>(numbers(0));
  motions.states.lambda = numbers.bottomRows(numbers.rows() - 1);
}

void add_dropped(const TiedModel& model, const Basis& basis, const MatrixXd& Mhat, const MatrixXd& answer,
                 const JudgedMotions& motions, MatrixXd& U) {
  const Index k = motions.n_modes;
  if (k == 0) return;
  const MatrixXd u_b =
      motions.states.Y.topLeftCorner(Mhat.cols(), k) * motions.states.lambda.head(k).asDiagonal();
  MatrixXd interior = linalg::times(answer, u_b), more;
  if (basis.Phi.cols() > 0) {
    const MatrixXd kept = basis.omega2.cwiseInverse().asDiagonal() * (model.inner(basis.Phi, Mhat) * u_b);
    interior -= linalg::times(basis.Phi, kept);
  }
  model.expand(interior, MatrixXd::Zero(model.n_b(), k), more);
  U.leftCols(k) += more;
}

MatrixXd on_all_nodes(const TiedModel& model, MatrixXd U) {
  if (!model.share()) return U;
  std::vector<mesh::Index> nodes(model.leads() ? static_cast<std::size_t>(model.share()->n_nodes) : 0);
  std::iota(nodes.begin(), nodes.end(), 0);
  return model.at_nodes(U, nodes);
}

}  // namespace flexura::reduce
