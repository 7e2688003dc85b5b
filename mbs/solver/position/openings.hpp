// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

namespace flexura::mbs {

/// A joint or constraint whose rows are not met: what residuals of position_constraints() mean.
struct Opening {
  std::string name;
  int marker_F = -1, marker_M = -1;               ///< -1 where it joins coordinates
  double length = 0.0, angle = 0.0, other = 0.0;  ///< norms of its residuals [m], [rad], plain numbers
};

/// The joints and constraints that residuals g (n_lambda) leave open, the widest first; those below a
/// millionth of it are not listed.
std::vector<Opening> openings_of(const Mechanism& mechanism, const Eigen::VectorXd& g);

/// "\"b\" (from \"rod.big\" to \"rocker.small\") by 9.96 mm and 1.2 deg"
std::string sentence_of(const Opening& opening, const MechanismDescription& d);

/// "N", "N m" of a row's multiplier, or "N or N m" where nothing says.
std::string force_unit_of(const Mechanism& mechanism, int row);

}  // namespace flexura::mbs
