// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "reduce/cms/result/options.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/part/part_input.hpp"

/// What is asked of parts of any kind, on their reductions.
namespace flexura::reduce {

/// The modes asked for and stiffening.
ReductionOptions options_of(const ReductionRequest& request);

/// Strikes modes out, tells of it, and returns the shapes that are left by those that were there (n x fewer); empty where none
/// goes.  Throws input::InputError.
Eigen::MatrixXd strike_out(const ReductionRequest& request, Reduction& reduction,
                           std::vector<std::string>& notes, std::vector<std::string>& warnings);

/// Adds [damping] to reduction.D_se and returns the ratio that is proposed to the runtime beside D_se: that of [modes], 0 where [damping] is
/// given, or where the part brings its own damping and [modes] gives none.  Below `critical_above` without a table that ratio holds.
double put_damping(const ReductionRequest& request, bool brings_damping, Reduction& reduction);

}  // namespace flexura::reduce
