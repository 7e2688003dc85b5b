// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/mechanism.hpp"

namespace flexura::mbs {

/// What start_quasi_static() (quasi_static_start.hpp) does for deformations that act back, for those that follow the motion without acting on
/// it (one_way_body.hpp): sets s where its loads hold it, s'' = 0, and s' = ds/dt along the motion.  `s` and `v_dot` are
/// those of the started motion.
void start_following(const Mechanism& m, State& s, const Eigen::VectorXd& v_dot);

}  // namespace flexura::mbs
