// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "beam/section/solver.hpp"
#include "mbs/base/documents/schema.hpp"
#include "mesh/gmsh/planar.hpp"

/// The input of `flexura section`: any cross-section from polygons with holes, thin walls or a planar CAD
/// face, meshed by gmsh and solved (beam/section/solver.hpp).  Reference page: cases/SECTION_FILE.md, printed
/// by `flexura section --schema`.
namespace flexura::reduce {

struct SectionInput {
  std::string name;
  mesh::PlanarOptions planar;
  std::vector<beam::Ply> plies;         ///< of each region; one for all faces of a CAD file
  std::vector<std::string> regions;     ///< "region.web" or "wall.flange" of each, for messages
  std::vector<std::string> warnings{};  ///< what is hardly meant
};

const input::TableSchema& section_file_schema();

/// Throws input::InputError.
SectionInput read_section_file(const std::filesystem::path& file,
                               const std::vector<std::string>& overrides = {});

/// Walls of a thin-walled section: each segment of the mid-line a rectangle, lengthened at corners to the
/// mitre.
std::vector<mesh::PlaneRegion> wall_regions(const mesh::PlaneLoop& midline, double thickness);

/// `warnings` gets what the mesh tells, those of the input among it.
beam::SectionProperties solve(const SectionInput& input, std::vector<std::string>* warnings = nullptr);

}  // namespace flexura::reduce
