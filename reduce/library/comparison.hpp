// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/superelement/report.hpp"

namespace flexura::reduce {

/// Frequencies of the free body and static compliance between the first and the last interface, nothing
/// reduced, against the superelement as it is written: full modes of the `struck` numbers (counted from 1,
/// rigid ones included) have no partner in it.
Comparison compare(const Part& part, const Reduction& reduction, int count, const std::vector<int>& struck,
                   const linalg::Progress& progress);

}  // namespace flexura::reduce
