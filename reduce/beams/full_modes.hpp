// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/beams/structure.hpp"
#include "reduce/linalg/dense/progress.hpp"

namespace flexura::reduce {

/// Modes of the free structure, nothing reduced, six rigid ones first: `count` elastic ones, or all up to omega_max [rad/s],
/// whichever asks for more; n_dofs x k.  `rotary_inertia` = false is for comparison with tables that lack it.  Needs a
/// linalg::Session.
Eigen::MatrixXd free_beam_shapes(const Structure& structure, int count, double omega_max = 0.0,
                                 bool rotary_inertia = true, const linalg::Progress& progress = {});

/// Their eigenvalues omega^2 [rad^2/s^2].
Eigen::VectorXd full_beam_modes(const Structure& structure, int count, bool rotary_inertia = true,
                                const linalg::Progress& progress = {});

}  // namespace flexura::reduce
