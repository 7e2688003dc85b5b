// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/sturm.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "reduce/assembly/shifted_solver.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"

namespace flexura::reduce {

namespace {
double gap_above(double omega2_last, double omega2_next) {
  return std::isfinite(omega2_next) ? omega2_next - omega2_last : 2.0 * linalg::kClusterGap * omega2_last;
}
}  // namespace

int count_modes_below(const TiedModel& model, double omega2, std::vector<int> order,
                      const linalg::FactorStorage& storage) {
  linalg::FactorStorage counting = storage;
  counting.to_count = model.A().rows() == 0;  // averages are eliminated by solves
  return ShiftedSolver(model, omega2, std::move(order), counting).n_below();
}

void certify(const TiedModel& model, const std::vector<int>& order, double omega2_last, double omega2_next,
             int n_modes, ReductionReport& report, const linalg::FactorStorage& storage) {
  linalg::FactorStorage single = storage;
  single.single = true;  // half the time: the factor is only to count
  certify([&](double omega2) { return count_modes_below(model, omega2, order, single); }, omega2_last,
          omega2_next, n_modes, report);
}

void certify(const std::function<int(double omega2)>& count, double omega2_last, double omega2_next,
             int n_modes, ReductionReport& report) {
  const double gap = gap_above(omega2_last, omega2_next);
  constexpr double kPlaces[] = {0.5, 0.35, 0.65, 0.42, 0.58};
  for (const double place : kPlaces) {
    report.certified_omega2 = omega2_last + place * gap;
    try {
      report.certified_modes = count(report.certified_omega2);
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

void note_count(double omega2_last, double omega2_next, int n_modes, ReductionReport& report) {
  report.certified_omega2 = omega2_last + 0.5 * gap_above(omega2_last, omega2_next);
  report.certified_modes = n_modes;
  report.notes.push_back(
      "the modes were found in slices of the spectrum, whose factors have counted them: no other certificate "
      "is needed");
}

}  // namespace flexura::reduce
