// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "reduce/cms/craig_bampton.hpp"

namespace flexura::reduce {

/// The load on the shapes T (n_dof x n), from the forces (n_dof x 1) that a field puts on the dofs of T's
/// rows.
///
/// Its torque about Bo by displacement follows from the same forces turned: as e_a . (phi x p) = phi . (p x
/// e_a), row a of `moment` is T^T of the field p x e_a.
ReducedLoad reduced_load(const LoadField& load, const Eigen::MatrixXd& T,
                         const std::function<Eigen::MatrixXd(const LoadField&)>& forces_on_dofs);

}  // namespace flexura::reduce
