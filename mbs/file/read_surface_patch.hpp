// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/kinematics/surface_patch.hpp"
#include "mbs/superelement/superelement.hpp"

/// Which part of a superelement's surface a force acts on, by the keys interfaces, box, facing and facing_angle of its section.
namespace flexura::mbs {

struct PatchOfSurface {
  std::shared_ptr<SurfacePatch> patch;
  std::vector<int> vertices;  ///< of the surface, in the order in which the patch was given them
  Eigen::VectorXd area;       ///< of each
};

/// The corners of the triangles that lie in all that the section names, each with a third of the areas around it.  Without
/// `deforms` shapes are not needed.  Throws InputError.
PatchOfSurface read_surface_patch(const input::Section& s, const superelement::Superelement& se,
                                  bool deforms);

/// Of its nodes by the superelement's coordinates: 3 n x n_se.
Eigen::MatrixXd shapes_of(const PatchOfSurface& part, const superelement::Superelement& se);
/// Loads p_se of a unit traction all over it along x, y and z: n_se x 3.
Eigen::MatrixXd tractions(const PatchOfSurface& part, const superelement::Superelement& se);

}  // namespace flexura::mbs
