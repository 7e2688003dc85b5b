// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "reduce/assembly/input/part.hpp"

/// Linear equations between nodal dofs (multipoint constraints) are eliminated: each makes one dof depend on others,
///
///     sum c_k q_k = 0   ->   q_d = -sum (c_k / c_d) q_k,
///
/// by Gauss's elimination, so that nothing depends on a dof that depends itself.
namespace flexura::reduce {

struct LinearEquation {
  std::vector<std::pair<NodalDof, double>>
      terms;       ///< the first is taken as the dependent dof where it can be
  std::string of;  ///< where it comes from, for messages
};

using NodePoints = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// The rigid motion of the whole body that an equation resists most, "a turn about x": it binds the body to the ground.
/// Empty where all fulfil it.
std::string resisted_motion(const LinearEquation& equation, const NodePoints& points);

/// The dependent dofs, ascending.  `may_depend` says of which dofs nothing else is said; rotations can follow one other
/// rotation alone.  Equations that say nothing new are left out.  Throws std::invalid_argument for an equation that a rigid
/// motion of the whole body would violate (it binds the body to the ground), and where no dof of one can depend.
std::vector<DependentDof> eliminate(const std::vector<LinearEquation>& equations, const NodePoints& points,
                                    const std::function<bool(const NodalDof&)>& may_depend);

}  // namespace flexura::reduce
