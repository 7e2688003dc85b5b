// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/linalg/factor/factor_store.hpp"

namespace flexura::reduce {

/// How many fixed-interface eigenvalues lie below omega2 [rad^2/s^2], by Sylvester's law of inertia (shifted_solver.hpp).  It
/// proves that an eigensolver has missed none.  Needs a linalg::Session;
/// std::runtime_error where the limit lies on an eigenvalue.
int count_modes_below(const TiedModel& model, double omega2, std::vector<int> order = {},
                      const linalg::FactorStorage& storage = {});

/// Counts between the last of `n_modes` kept eigenvalues and the first left out (infinite where there is
/// none), and notes both in the report; a limit at which no factor is good enough (linalg::IndefiniteFactor)
/// is moved within that gap.  std::runtime_error where the counts differ.
void certify(const TiedModel& model, const std::vector<int>& order, double omega2_last, double omega2_next,
             int n_modes, ReductionReport& report, const linalg::FactorStorage& storage = {});

/// The same with any count of the eigenvalues below a limit, which throws std::runtime_error where it must be moved.
void certify(const std::function<int(double omega2)>& count, double omega2_last, double omega2_next,
             int n_modes, ReductionReport& report);

/// What slices of the spectrum have counted already (linalg::EigenPairs::counted): no mode up to the last is missing.
void note_count(double omega2_last, double omega2_next, int n_modes, ReductionReport& report);

}  // namespace flexura::reduce
