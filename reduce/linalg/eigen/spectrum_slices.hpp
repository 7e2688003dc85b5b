// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/eigen/block_lanczos.hpp"

namespace flexura::linalg {

/// Many lowest eigenpairs slice by slice.  Shifts sigma_1 < sigma_2 < ... rise through the spectrum; from each of them,
/// and from the problem's own below it, block Lanczos finds the nearest eigenvalues on both sides,
///
///     S_j = (K - sigma_j M)^-1 M,    theta = 1 / (omega^2 - sigma_j),
///
/// and the factor of K - sigma_j M counts those below sigma_j.  So it is known how many lie between what the shift before
/// has found and sigma_j, and exactly these must be found from here: the slices certify one another.  The last shift lies
/// beyond what is asked for, so its count is the certificate of all.  A slice ends in the widest of some gaps beside its
/// last eigenvalues, so that no cluster is cut; vectors are made M-orthogonal to those of the slices before.
/// R. G. Grimes, J. G. Lewis, H. D. Simon, SIAM J. Matrix Anal. Appl. 15 (1994), 228, sections 4 and 5.
///
/// The basis of a slice is short: orthogonalisation grows with (modes) x (modes of a slice) in place of (modes)^2.
struct SliceSettings {
  int modes = 0;  ///< of a slice
  BlockLanczosSettings lanczos;
};
/// For problems that can be shifted.  Throws std::runtime_error where the counts and what is found do not agree.
EigenPairs iterate_slices(const EigenProblem& problem, const EigenRequest& request,
                          const SliceSettings& settings, const Progress& progress = {});

/// Right-hand sides together in slices: their bases are short, so that fewer vectors gain more than rarer passes along them.
inline constexpr int kSliceBlock = 8;
/// How many modes a slice should have, `count` being asked for, with blocks of `block`; 0: one basis for all is faster, or
/// there is no way to shift.  `n_rows` is the length of the vectors on all processes.  By operations, not by time: the same
/// each time.
int modes_per_slice(const EigenProblem& problem, double n_rows, int count, int block);

/// The number of eigenvalues up to omega^2 grows like omega^(2 p): p by the upper half of the lowest ones, ascending.
double growth_of_number(const Eigen::VectorXd& omega2);
/// How many there may be below a limit, by this.
double expected_below(const Eigen::VectorXd& omega2, double limit);

/// Vectors of the basis of a slice, where there is room for `room` of them.
int slice_vectors(int modes, int block, double room);

}  // namespace flexura::linalg
