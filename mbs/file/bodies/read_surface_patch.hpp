// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/kinematics/surface_mesh.hpp"
#include "mbs/kinematics/surface_patch.hpp"
#include "mbs/superelement/superelement.hpp"

/// Which part of a superelement's surface a force acts on, by the keys interfaces, box, facing and facing_angle of its section.
namespace flexura::mbs {

struct PatchOfSurface {
  std::shared_ptr<SurfacePatch> patch;  ///< of its nodes
  std::shared_ptr<SurfaceMesh> mesh;    ///< of its facets, where these are touched
  std::vector<int> vertices;  ///< of the surface, in the order in which patch or mesh were given them
  Eigen::VectorXd area;       ///< of each

  void set_shapes(const Eigen::MatrixXd& Phi) const {
    if (patch) patch->set_shapes(Phi);
    if (mesh) mesh->set_shapes(Phi);
  }
};

/// The keys by which a section names a part of the surface of a body.
struct SurfaceKeys {
  std::string body, prefix;  ///< of the body, and what stands before the others' names
};

/// The corners of the triangles that lie in all that the section names, each with a third of the areas around it.  Without
/// `deforms` shapes are not needed.  Throws InputError.
PatchOfSurface read_surface_patch(const input::Section& s, const superelement::Superelement& se,
                                  bool deforms);
/// These triangles.
PatchOfSurface read_touched_surface(const input::Section& s, const superelement::Superelement& se,
                                    bool deforms, const SurfaceKeys& keys);

/// Of its nodes by the superelement's coordinates: 3 n x n_se.
Eigen::MatrixXd shapes_of(const PatchOfSurface& part, const superelement::Superelement& se);
/// Loads p_se of a unit traction all over it along x, y and z: n_se x 3.
Eigen::MatrixXd tractions(const PatchOfSurface& part, const superelement::Superelement& se);

}  // namespace flexura::mbs
