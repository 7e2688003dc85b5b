// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mesh/model/mesh.hpp"

/// The elements that an Abaqus (or CalculiX) deck names, and what they become here.
namespace flexura::mesh::abaqus {

/// An Abaqus solid element: its shape and what its letters mean here.
struct SolidType {
  CellType shape;
  CellVariant variant = CellVariant::standard;
  std::string replaced;  ///< what is computed instead and what it does; empty where it is that element
};

/// "C3D8R" -> hex8; nothing for what is no solid.
std::optional<SolidType> solid_type(const std::string& name);

/// "S4R" -> quad4.  Conventional shells of six dofs a node; reduced ones and those of five dofs are computed as the full.
std::optional<SolidType> shell_type(const std::string& name);

/// How many nodes the elements have that are no cells: beams, trusses, point masses, springs.  Beams and trusses of three
/// become two of two.
const std::map<std::string, std::size_t>& other_elements();

/// Abaqus' order of a cell's nodes -> that of Mesh.
std::vector<std::int64_t> in_mesh_order(CellType type, const std::vector<std::int64_t>& n);

/// The corners of a solid's face S1, S2, ... (from 0), in Abaqus' numbering; empty for faces that there are not.
std::vector<int> face_corners(CellType type, int face);

}  // namespace flexura::mesh::abaqus
