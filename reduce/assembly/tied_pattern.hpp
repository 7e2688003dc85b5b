// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "reduce/assembly/ties/tied_numbering.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"

namespace flexura::reduce {

/// The entries that a part's elements, links and ties make; all values are 0.
struct TiedPatterns {
  std::unique_ptr<linalg::SymmetricMatrix> K_ii;  ///< by dofs
  std::unique_ptr<linalg::SymmetricMatrix> m;     ///< by nodes
};
TiedPatterns tied_patterns(const Part& part, const TiedNumbering& numbering);

}  // namespace flexura::reduce
