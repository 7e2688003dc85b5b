// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

/// Damping of a body's modes: the ratio zeta_i in d_i = 2 zeta_i omega_i.
namespace flexura::mbs {

/// At most one of ratio, by_mode, the table and Rayleigh's law is given; critical_above works on all of them.
struct DampingLaw {
  std::optional<double> ratio;              ///< the same for all modes
  std::vector<double> by_mode;              ///< of mode 1, 2, ...; the last one also of all above
  std::vector<double> table_hz, table;      ///< linear between the frequencies [Hz], constant outside
  std::optional<Eigen::Vector2d> rayleigh;  ///< (alpha [1/s], beta [s]): D = alpha M + beta K
  /// From here on [Hz] modes are damped critically: they follow their loads without ringing.
  double critical_above = std::numeric_limits<double>::infinity();

  bool given() const { return ratio || !by_mode.empty() || !table.empty() || rayleigh; }
};

/// d_i = 2 zeta_i omega_i of mass-normalised modes with the given omega^2.  `without_law` (m) is what holds
/// where the law gives nothing.  Throws std::invalid_argument for a table whose frequencies do not rise.
Eigen::VectorXd modal_damping(const DampingLaw& law, const Eigen::VectorXd& omega2,
                              const Eigen::VectorXd& without_law);

}  // namespace flexura::mbs
