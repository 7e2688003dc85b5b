// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/beams/structure.hpp"
#include "reduce/linalg/dense/progress.hpp"

namespace flexura::reduce {

/// Eigenvalues omega^2 [rad^2/s^2] of the free structure, nothing reduced: six rigid ones, then `count`
/// elastic ones. `rotary_inertia` = false is for comparison with tables that lack it.  Needs a
/// linalg::Session.
Eigen::VectorXd full_beam_modes(const Structure& structure, int count, bool rotary_inertia = true,
                                const linalg::Progress& progress = {});

}  // namespace flexura::reduce
