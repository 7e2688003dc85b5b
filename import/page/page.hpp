// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "import/cad/joints/build.hpp"
#include "mbs/view/parts_page.hpp"

namespace flexura::import {

/// One sentence: which bodies overlap, by how much and where.
std::string overlap_text(const cad::Overlap& overlap, const std::string& a, const std::string& b);

/// What the page shows of an assembly: its parts with numbered faces, its bodies where the file has them, the proposed joints and
/// what overlaps.
view::PartsPage page_of(const cad::Assembly& assembly, const cad::Built& built,
                        const std::vector<cad::Overlap>& overlaps);

}  // namespace flexura::import
