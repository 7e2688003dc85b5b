// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/errors/choose_modes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <numbers>
#include <stdexcept>

#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

using Eigen::MatrixXd;

InteriorMass interior_mass(const TiedModel& model) {
  MatrixXd M_R;
  MatrixXd R = model.motions().rigid_nodes(), R_b = model.motions().rigid_b();
  model.m().multiply_kron3(R, M_R);
  const MatrixXd inertia = model.inner(R, M_R);
  const Eigen::Vector3d centre = Eigen::Vector3d(inertia(1, 5), inertia(2, 3), inertia(0, 4)) / inertia(0, 0);
  for (MatrixXd* motions : {&R, &R_b})
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d shift = Eigen::Vector3d::Unit(a).cross(centre);
      motions->col(3 + a) = (motions->col(3 + a) - motions->leftCols(3) * shift).eval();
    }
  const MatrixXd R_i =
      model.own_rows(model.motions().interior_part(R, model.motions().rigid_rotations(), [&] {
        std::vector<MatrixXd> motions;
        for (int k = 0; k < model.n_interfaces(); ++k)
          motions.push_back(node_motion_at(model.numbering().point(k) - centre));
        return motions;
      }()));
  MatrixXd M_R_i;
  model.multiply_M(R_i, M_R_i);
  MatrixXd of_interior = model.inner(R_i, M_R_i);
  return {std::move(R_b), std::move(of_interior)};
}

void choose_modes(const ReductionOptions& options, const InteriorDynamics& interior,
                  const std::function<InteriorMass()>& mass,
                  const std::function<void(int, double)>& solve_for, linalg::EigenPairs& pairs,
                  ReductionReport& report) {
  const auto keep = [&](int count) {
    if (count < pairs.omega2.size()) pairs.omega2_next = pairs.omega2(count);
    pairs.omega2.conservativeResize(count);
    pairs.residual.conservativeResize(count);
    if (pairs.round_off.size() > count) pairs.round_off.conservativeResize(count);
    pairs.Phi.conservativeResize(Eigen::NoChange, count);
  };
  const double hertz = options.omega_max / (2.0 * std::numbers::pi);
  if (options.accuracy > 0.0) {
    BandError reached;
    for (const double reach : {1.5, 2.2, 3.3, 5.0, 8.0, 13.0, 20.0, 35.0}) {
      solve_for(0, reach * options.omega_max);
      if (const auto count = modes_for_accuracy(interior, options.omega_max, options.accuracy)) {
        report.notes.push_back(fmt::format("{} modes for an accuracy of {:.3g} % up to {:.5g} Hz", *count,
                                           100.0 * options.accuracy, hertz));
        keep(*count);
        return;
      }
      reached =
          band_error(with_first_modes(interior, static_cast<int>(pairs.omega2.size())), options.omega_max);
      if (pairs.omega2.size() >= options.most_modes) break;
    }
    throw std::invalid_argument(fmt::format(
        "an accuracy of {:.3g} % up to {:.5g} Hz is out of reach: with {} modes the estimate is {:.2g} % for "
        "frequencies and {:.2g} % for the interface's dynamic stiffness; ask for less, or for a lower "
        "frequency",
        100.0 * options.accuracy, hertz, pairs.omega2.size(), 100.0 * reached.frequency,
        100.0 * reached.interface));
  }
  const InteriorMass whole = mass();
  for (int n = 24;; n *= 2) {
    solve_for(std::min(n, options.most_modes), 0.0);
    if (const auto count =
            modes_for_effective_mass(interior, whole.R_b, whole.inertia, options.effective_mass)) {
      report.notes.push_back(fmt::format("{} modes for {:.4g} % of the effective mass in every direction",
                                         *count, 100.0 * options.effective_mass));
      keep(*count);
      return;
    }
    if (n >= options.most_modes || pairs.omega2.size() < n)
      throw std::invalid_argument(
          fmt::format("{:.4g} % of the effective mass is out of reach: {} modes do not have it; ask for less",
                      100.0 * options.effective_mass, pairs.omega2.size()));
  }
}

}  // namespace flexura::reduce
