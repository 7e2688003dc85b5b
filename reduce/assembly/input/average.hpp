// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/input/part.hpp"

namespace flexura::reduce {

/// The averaging tie (RBE3).  The interface node's motion q = (u, theta) is the rigid motion that fits the
/// displacements of the faces best in the mean over their area:
///
///     q = argmin integral |u(x) - D(x) q|^2 dA = (D^T W D)^-1 D^T W u_set,   D(x) = [1, -(x - x_N) x]
///
/// with W_ac = integral N_a N_c dA (times I_3), or the given
/// weights of the nodes, or the unit matrix where the set has no faces.  Faces are
/// isoparametric, so a rigid motion of the set is reproduced exactly, and a load on the interface node
/// becomes a linear traction over the faces that is statically equivalent to it.
///
/// Returns the 6 x 3 n_S matrix of this map (columns x, y, z of node 0 of the set, ...).
/// Rotations that nodes on a line or in a point do not determine are zero in it.
Eigen::Matrix<double, 6, Eigen::Dynamic> averaging_map(const mesh::Mesh& mesh,
                                                       const InterfaceSpec& interface);

/// A point that moves by C (u, theta) of the node that follows the set of `average`; `map` is its averaging_map.
Follower follower_of(mesh::Index point, const Eigen::Matrix<double, 3, 6>& C, const InterfaceSpec& average,
                     const Eigen::Matrix<double, 6, Eigen::Dynamic>& map);

}  // namespace flexura::reduce
