// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/modal_damping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace flexura::mbs {
namespace {

double interpolated(const std::vector<double>& x, const std::vector<double>& y, double at) {
  if (at <= x.front()) return y.front();
  if (at >= x.back()) return y.back();
  const auto k = std::upper_bound(x.begin(), x.end(), at) - x.begin();
  return y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1]);
}

}  // namespace

Eigen::VectorXd modal_damping(const DampingLaw& law, const Eigen::VectorXd& omega2,
                              const Eigen::VectorXd& without_law) {
  if (law.table.size() != law.table_hz.size())
    throw std::invalid_argument(
        fmt::format("the damping table has {} frequencies and {} ratios; give one ratio for "
                    "each frequency",
                    law.table_hz.size(), law.table.size()));
  for (std::size_t k = 1; k < law.table_hz.size(); ++k)
    if (!(law.table_hz[k] > law.table_hz[k - 1]))
      throw std::invalid_argument(
          fmt::format("the damping table's frequency {} Hz does not lie above the one "
                      "before it, {} Hz; sort the table",
                      law.table_hz[k], law.table_hz[k - 1]));
  Eigen::VectorXd d = without_law;
  for (Eigen::Index i = 0; i < omega2.size(); ++i) {
    const double omega = std::sqrt(omega2(i)), hz = omega / (2.0 * std::numbers::pi);
    if (law.ratio) d(i) = 2.0 * *law.ratio * omega;
    if (!law.by_mode.empty())
      d(i) = 2.0 * omega * law.by_mode[std::min<std::size_t>(i, law.by_mode.size() - 1)];
    if (!law.table.empty()) d(i) = 2.0 * omega * interpolated(law.table_hz, law.table, hz);
    if (law.rayleigh) d(i) = (*law.rayleigh)(0) + (*law.rayleigh)(1) * omega2(i);
    if (hz >= law.critical_above) d(i) = std::max(d(i), 2.0 * omega);
  }
  return d;
}

}  // namespace flexura::mbs
