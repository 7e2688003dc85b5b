// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "reduce/linalg/dense/trapezoid.hpp"

namespace flexura::linalg {

/// Factorises the columns of a front, F = [F_11; F_21] -> [L_11; L_21] with F_11 = L_11 S L_11^T and
/// L_21 = F_21 L_11^-T S, and takes U -= L_21 S L_21^T, the lower triangle of what is left to the rows below.
/// F is a trapezoid; U that of all columns of its own.  The signs S of the pivots are written to `signs`.
/// Returns -1, or the column at which a pivot is zero, not finite or, where the matrix must be definite, not
/// positive.  With `on_all_cores` large products are shared among the machine's cores; the result is the
/// same.  Real: double or float.
template <class Real>
std::ptrdiff_t factorise_front(const Trapezoid& shape, Real* F, Real* U, double* signs, bool must_be_definite,
                               bool on_all_cores);

}  // namespace flexura::linalg
