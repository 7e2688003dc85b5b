// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/estimate/enriched_mesh.hpp"
#include "reduce/linalg/dense/progress.hpp"

/// r(w) = lambda m(u, w) - a(u, w) of all functions that a mesh gains (enriched_error.hpp), in one pass over its cells: eight
/// of a type have their matrices computed together, which then meet all states.
namespace flexura::reduce {

/// States together: those of a part with two interfaces.  Cells' matrices come from memory once for all of them.
inline constexpr int kStatesTogether = 16;
using StatePanel = Eigen::Matrix<float, Eigen::Dynamic, kStatesTogether, Eigen::RowMajor>;

struct EnrichedResidual {
  std::vector<StatePanel> r;     ///< 3 n_functions x 16 each
  std::vector<float> stiffness;  ///< 3 n_functions: of each function by itself
};

/// Displacements U: 3 n_nodes x k.
EnrichedResidual enriched_residual(const Part& part, const EnrichedMesh& mesh, const Eigen::MatrixXd& U,
                                   const Eigen::VectorXd& lambda, const linalg::Progress& progress);

}  // namespace flexura::reduce
