// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "mbs/superelement/superelement.hpp"

/// A few places of a superelement's surface at which a body is looked at, chosen once: where a shape moves the
/// most, where one strains an edge the most, and some spread over the surface.  What they cost in a run depends
/// on the number of modes, not on the mesh.
namespace flexura::mbs {

struct DeformationProbes {
  Eigen::Matrix3Xd points;        ///< undeformed, in B [m]
  Eigen::MatrixXd displacements;  ///< 3 n x m, u of point 0, then 1, ... by the modal coordinates
  /// Of edges (x_1, x_2) of the surface: e = (x_2 - x_1) . (u_2 - u_1) / |x_2 - x_1|^2, which no small rigid
  /// motion changes.
  Eigen::MatrixXd strains;         ///< n_e x m
  Eigen::Matrix3Xd strain_places;  ///< their middles [m]
  double size = 0.0;               ///< diagonal of the surface's bounding box [m]
};

/// Of the surface, for modal coordinates s with u_se = Y s.  Empty (no points) where it has none.
DeformationProbes probes_of(const superelement::Superelement& se, const Eigen::MatrixXd& Y);

}  // namespace flexura::mbs
