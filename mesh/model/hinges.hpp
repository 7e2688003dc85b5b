// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

#include "mesh/model/mesh.hpp"

namespace flexura::mesh {

/// A place where solid cells that no face joins share an edge (`line`) or a node alone: they turn about it without strain.
struct MeshHinge {
  Eigen::Vector3d at;  ///< of a node on it [m]
  bool line = false;
};

/// One of the hinges of a mesh of solids, if it has any.  What shares three nodes that lie in no line is joined (bricks beside
/// tetrahedra).
std::optional<MeshHinge> find_hinge(const Mesh& mesh);

}  // namespace flexura::mesh
