// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/linalg/factor/factor_store.hpp"

namespace flexura::linalg {

/// What PETSc's interface has no words for, of a factorisation by the package fronts (fronts_package.hpp).
struct FrontsHints {
  std::vector<int> order;  ///< row order[k] is eliminated as number k; empty: nested dissection
  FactorStorage storage;
};

}  // namespace flexura::linalg
