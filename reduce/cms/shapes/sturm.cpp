// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/sturm.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "reduce/assembly/model_factor.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"

namespace flexura::reduce {

int count_modes_below(const TiedModel& model, double omega2, std::vector<int> order,
                      const linalg::FactorStorage& storage) {
  const ModelFactor factor = ModelFactor::shifted(model, -omega2, std::move(order), storage);
  const auto n_a = static_cast<int>(model.A().rows());
  if (n_a == 0) return factor.n_negative();
  const Eigen::MatrixXd At = Eigen::MatrixXd(model.A().transpose());
  const Eigen::MatrixXd S = model.A() * factor.solve(At);
  const Eigen::VectorXd values = linalg::symmetric_eigen(-0.5 * (S + S.transpose())).values;
  return factor.n_negative() + static_cast<int>((values.array() < 0.0).count()) - n_a;
}

void certify(const TiedModel& model, const std::vector<int>& order, double omega2_last, double omega2_next,
             int n_modes, ReductionReport& report, const linalg::FactorStorage& storage) {
  const double gap =
      std::isfinite(omega2_next) ? omega2_next - omega2_last : 2.0 * linalg::kClusterGap * omega2_last;
  linalg::FactorStorage single = storage;
  single.single = true;  // half the time: the factor is only to count
  constexpr double kPlaces[] = {0.5, 0.35, 0.65, 0.42, 0.58};
  for (const double place : kPlaces) {
    report.certified_omega2 = omega2_last + place * gap;
    try {
      report.certified_modes = count_modes_below(model, report.certified_omega2, order, single);
      break;
    } catch (const std::runtime_error&) {
      if (place == std::end(kPlaces)[-1]) throw;
    }
  }
  if (report.certified_modes == n_modes) return;
  throw std::runtime_error(
      fmt::format("the eigensolver found {} modes below {:.6g} Hz, by Sylvester's law there are {}; ask for "
                  "a few more modes",
                  n_modes, frequency_hz(report.certified_omega2), report.certified_modes));
}

}  // namespace flexura::reduce
