// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/mode_choice.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "mbs/bodies/modal_problem.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The number of modes, lowest first, that hold `share` of the mass and inertia of all of them in every held direction: of the sums
// of (phi^T M_se r)^2 over the modes, r the rigid motion along that direction alone.
int count_by_effective_mass(const superelement::Superelement& se, const MatrixXd& held, const MatrixXd& Phi,
                            double share) {
  const MatrixXd R = superelement::rigid_motions(se), along = held.transpose() * R;
  const MatrixXd r = R * along.completeOrthogonalDecomposition().pseudoInverse();
  const MatrixXd shares = (Phi.transpose() * se.M_se * r).cwiseAbs2();
  const VectorXd all = shares.colwise().sum();
  VectorXd sum = VectorXd::Zero(all.size());
  // Of a direction in which no mode resists the shares are round-off of the body's own mass or inertia.
  constexpr double kRoundOff = 1e-12;
  const VectorXd nothing = kRoundOff * (r.transpose() * se.M_se * r).diagonal();
  int count = 0;
  for (; count < shares.rows(); ++count) {
    if (((sum - share * all).array() >= -nothing.array()).all()) break;
    sum += shares.row(count).transpose();
  }
  return count;
}

}  // namespace

double frequency_of(double omega2) {
  return std::sqrt(omega2) / (2.0 * std::numbers::pi);
}

std::vector<int> chosen_modes(const superelement::Superelement& se, const BasisOptions& options,
                              const VectorXd& omega2, const std::function<MatrixXd()>& shapes) {
  const int available = static_cast<int>(omega2.size());
  int strainless = 0;
  while (strainless < available && omega2(strainless) == 0.0) ++strainless;
  std::vector<int> chosen(static_cast<std::size_t>(strainless));
  std::iota(chosen.begin(), chosen.end(), 0);
  for (const int number : options.numbers)
    if (number < 1 || number > available - strainless)
      throw BasisError(
          "modes", fmt::format("there is no eigenmode {}: the body has {} under its boundary condition; name "
                               "some of these",
                               number, available - strainless));
  if (options.effective_mass > 0.0 && options.held.cols() == 0)
    throw BasisError(
        "effective_mass",
        "modes of the free body carry no mass of a motion of their supports; hold them by a joint "
        "(boundary = \"joint\")");
  const int most = options.effective_mass > 0.0
                       ? std::min(options.modes,
                                  count_by_effective_mass(se, options.held, shapes(), options.effective_mass))
                       : options.modes;
  for (int i = strainless; i < available; ++i) {
    const bool is_wanted =
        options.numbers.empty() ? i < most : std::ranges::count(options.numbers, i - strainless + 1) > 0;
    if (is_wanted && frequency_of(omega2(i)) <= options.max_frequency) chosen.push_back(i);
  }
  return chosen;
}

}  // namespace flexura::mbs
