// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

/// The motion that carries a surface along itself (N. Gelfand, L. Guibas, Shape segmentation using local slippage analysis, SGP 2004):
/// the twist (omega, v) whose velocity v + omega x p is tangential at all its points,
///
///     n_i . (v + omega x p_i) = 0.
///
/// The flanks of a thread have one, a screw; a torus, a fillet about an axis one, a rotation.
namespace flexura::import::cad {

struct Slippage {
  Eigen::Vector3d point, axis;  ///< of the screw; the axis a unit vector
  double lead = 0.0;            ///< along the axis in one turn, negative: a left-hand thread; 0: a rotation
};

/// Of points of a surface and its unit normals. Nothing where there is none, more than one (planes, cylinders, spheres) or a
/// translation.
std::optional<Slippage> slippage_of(const Eigen::Matrix<double, Eigen::Dynamic, 3>& points,
                                    const Eigen::Matrix<double, Eigen::Dynamic, 3>& normals);

}  // namespace flexura::import::cad
