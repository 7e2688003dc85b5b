// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/assembly/input/part.hpp"

/// Some of a large mesh's cells, from which all are told: pieces of the part, those that have most of an error first,
/// others at random places (every so many in their order).  On the others an indicator that is known everywhere counts by
/// its ratio on the random ones (W. G. Cochran, Sampling Techniques, chapter 6).
namespace flexura::reduce {

struct CellSample {
  std::vector<std::size_t> cells;  ///< piece by piece
  std::vector<char> random;        ///< of the cells: from a piece at a random place
};

/// All cells of a mesh of less than eight hundred.  indicator: n_cells x k, of k states.
CellSample choose_cells(const Part& part, const Eigen::MatrixXf& indicator);

/// Puts what is known of the sample (n_sample x k) in the place of the indicator, and on the other cells the indicator
/// times its ratio.
void extend(const CellSample& sample, const Eigen::MatrixXf& of_sample, Eigen::MatrixXf& indicator);

}  // namespace flexura::reduce
