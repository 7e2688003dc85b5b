// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mesh/model/mesh.hpp"

/// One side of sheets whose cells are numbered either way round.
namespace flexura::mesh {

struct ShellSides {
  std::vector<std::vector<char>> turned;  ///< of each block, of each cell: its normal looks to the other side
  int n_turned = 0, n_shells = 0;
};

/// Makes the shells among `faces` (cells that stand in mesh.shells) look to one side, piece by piece; shells that share an edge
/// that no third one has are one piece.  With `side` a piece looks along it: its normals do in the mean, or, where they add up to nothing
/// (a closed shell), those of the cells that lie farthest along it.  Without it a piece keeps the side of three quarters of its area.  Faces of
/// solids look outwards and are left alone.  Throws std::invalid_argument where no three quarters agree, a piece has one side only (a Moebius strip),
/// or `side` lies in a piece.
ShellSides shells_of_one_side(const Mesh& mesh, std::span<const CellBlock> faces,
                              const std::optional<Eigen::Vector3d>& side);

/// The cells that are (or are not) turned alone, for integrals over them.
std::vector<CellBlock> cells_where(std::span<const CellBlock> faces, const ShellSides& sides, bool turned);

}  // namespace flexura::mesh
