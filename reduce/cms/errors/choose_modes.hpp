// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/cms/errors/mode_choice.hpp"
#include "reduce/cms/result/options.hpp"

namespace flexura::reduce {

/// The interior's own mass: `inertia` (6 x 6) of the rigid motions whose interface dofs are R_b (n_b x 6), about the mass centre.
struct InteriorMass {
  Eigen::MatrixXd R_b, inertia;
};
InteriorMass interior_mass(const TiedModel& model);

/// Fixed-interface modes until the options' accuracy or effective mass is reached; what was computed beyond
/// it is cut off.  `solve_for(count, omega)` fills `pairs` and `interior`; `mass` is asked for effective mass alone.
/// std::invalid_argument, with what was reached, where the goal is out of reach.
void choose_modes(const ReductionOptions& options, const InteriorDynamics& interior,
                  const std::function<InteriorMass()>& mass,
                  const std::function<void(int, double)>& solve_for, linalg::EigenPairs& pairs,
                  ReductionReport& report);

}  // namespace flexura::reduce
