// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/cms/errors/mode_choice.hpp"
#include "reduce/cms/result/options.hpp"

namespace flexura::reduce {

/// Fixed-interface modes until the options' accuracy or effective mass is reached; what was computed beyond
/// it is cut off.  `solve_for(count, omega)` fills `pairs` and `interior`.  std::invalid_argument, with what
/// was reached, where the goal is out of reach.
void choose_modes(const TiedModel& model, const ReductionOptions& options, const InteriorDynamics& interior,
                  const std::function<void(int, double)>& solve_for, linalg::EigenPairs& pairs,
                  ReductionReport& report);

}  // namespace flexura::reduce
