// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mesh/import/bar_sections.hpp"

/// The cross-sections that PBARL and PBEAML name by shape.
namespace flexura::mesh {

/// A section of PBARL and PBEAML (MSC Nastran's shapes but HAT1, DBOX and those of other programs) by its dimensions DIM1, ... in the
/// deck's unit of length.  Throws std::invalid_argument for shapes that are not known, too few dimensions, or dimensions that
/// leave no material.
BarSection nastran_section(const std::string& type, const std::vector<double>& dim);

/// How many dimensions a shape has.  Throws std::invalid_argument for one that is not known.
std::size_t nastran_dimensions(const std::string& type);

}  // namespace flexura::mesh
