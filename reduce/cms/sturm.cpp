// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/sturm.hpp"

#include "reduce/assembly/tied_model.hpp"
#include "reduce/linalg/dense.hpp"
#include "reduce/linalg/inertia.hpp"

namespace flexura::reduce {

int count_modes_below(const Part& part, double omega2) {
  AssemblyOptions options;
  options.shift = -omega2;
  const TiedModel model(part, options);
  const linalg::IndefiniteFactor factor(model.K_ii());
  const auto n_a = static_cast<int>(model.A().rows());
  if (n_a == 0) return factor.n_negative();
  const Eigen::MatrixXd At = Eigen::MatrixXd(model.A().transpose());
  const Eigen::MatrixXd S = model.A() * factor.solve(At);
  const Eigen::VectorXd values = linalg::symmetric_eigen(-0.5 * (S + S.transpose())).values;
  return factor.n_negative() + static_cast<int>((values.array() < 0.0).count()) - n_a;
}

}  // namespace flexura::reduce
