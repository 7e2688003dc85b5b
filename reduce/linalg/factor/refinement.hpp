// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/linalg/factor/supernodal_factor.hpp"

/// What a factor L S L^T = A + E is worth whose round-off E matters: in single precision, or without pivoting.
namespace flexura::linalg {

/// Whether the factor has A's inertia.  Where it has not, A + t E is singular for a t between 0 and 1, w its null vector:
/// w is a left eigenvector of G = E (A + E)^-1 with an eigenvalue of modulus 1 or more.  Refinement of x = A^-1 b has the
/// residuals r_k = G^k b, so that w^T r_k never falls below w^T b, which is normally distributed for a random b.
/// Therefore the residuals of eight random b fall below 0.1 only where the inertia is right, but for once in 1e9.
///
/// Single precision is refined up to eight times, products with A in double precision; double precision once, since its
/// residuals are not known any better.
bool stands_the_test(const SupernodalFactor& L, const UpperCsr& A);

/// X = L^-T S L^-1 B becomes A^-1 B: corrections, each the residual solved for, until the next one would be round-off of
/// X, or they no longer fall (N. J. Higham, Accuracy and Stability of Numerical Algorithms, SIAM 2002, chapter 12).
void refine(const SupernodalFactor& L, const UpperCsr& A, const Eigen::Ref<const Eigen::MatrixXd>& B,
            Eigen::Ref<Eigen::MatrixXd> X);

}  // namespace flexura::linalg
