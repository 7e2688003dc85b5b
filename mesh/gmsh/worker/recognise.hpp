// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "mesh/model/face.hpp"

namespace flexura::mesh {

/// Tells planes, cylinders, cones and spheres from points p_k and outward unit normals n_k on a surface,
/// whatever the CAD file calls it (real cylinders often come as B-splines or "Unknown").
///
///   plane     all n_k equal;
///   sphere    p_k = c + R n_k;
///   cylinder  n_k . a = 0 (a = singular vector of the normals' least singular value), p_k = c + R n_k across
///   a; cone      n_k . a = const, n_k . (p_k - apex) = 0;
///
/// R < 0 is a hole.  Least squares, accepted where the residual is below 1e-5 of the points' extent.
/// Sets kind, normal, axis_point, axis, radius, length and hole of `face`.
void recognise(const Eigen::Matrix<double, Eigen::Dynamic, 3>& points,
               const Eigen::Matrix<double, Eigen::Dynamic, 3>& normals, Face& face);

}  // namespace flexura::mesh
