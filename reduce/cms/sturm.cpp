// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/sturm.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/linalg/dense.hpp"
#include "reduce/linalg/eigen_problem.hpp"
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

void certify(const Part& part, double omega2_last, double omega2_next, int n_modes, ReductionReport& report) {
  report.certified_omega2 = std::isfinite(omega2_next) ? 0.5 * (omega2_last + omega2_next)
                                                       : omega2_last * (1.0 + linalg::kClusterGap);
  report.certified_modes = count_modes_below(part, report.certified_omega2);
  if (report.certified_modes == n_modes) return;
  throw std::runtime_error(
      fmt::format("the eigensolver found {} modes below {:.6g} Hz, by Sylvester's law there are {}; ask for "
                  "a few more modes",
                  n_modes, frequency_hz(report.certified_omega2), report.certified_modes));
}

}  // namespace flexura::reduce
