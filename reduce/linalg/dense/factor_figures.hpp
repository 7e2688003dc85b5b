// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace flexura::linalg {

/// What a factorisation cost.
struct FactorFigures {
  double nonzeros = 0.0;  ///< of L
  double flops = 0.0;
  double bytes = 0.0;             ///< of what is stored, zeros within supernodes included
  bool in_file = false;           ///< it did not fit into memory, or a file was asked for (factor_store.hpp)
  bool single = false;            ///< kept in single precision
  double seconds_ordering = 0.0;  ///< METIS
  double seconds_symbolic = 0.0;
  double seconds_numeric = 0.0;
  double processor_seconds = 0.0;  ///< of the numeric part, on all cores together
  double smallest_pivot = 0.0;     ///< the smallest L_jj^2 / A_jj; round-off level means a mechanism
};

}  // namespace flexura::linalg
