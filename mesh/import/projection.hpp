// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "mesh/model/mesh.hpp"

/// Points on surfaces of other cells: what a node of *TIE follows where the meshes do not match.
namespace flexura::mesh {

/// A face of a solid, or a shell: tri3, tri6, quad4, quad8 with its nodes.
struct SurfaceFace {
  CellType type;
  std::vector<Index> nodes;
};

struct Projection {
  std::size_t face = 0;
  Eigen::VectorXd N;                                ///< of the face's nodes at the place
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< sum N_k x_k
  double distance = 0;
};

/// The place nearest to a point on the faces, their edges included, not farther away than `reach`.
std::optional<Projection> project(const Eigen::Vector3d& point, const std::vector<SurfaceFace>& faces,
                                  const std::function<const Eigen::Vector3d&(Index)>& place_of, double reach);

}  // namespace flexura::mesh
