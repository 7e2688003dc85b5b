// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "import/cad/build.hpp"
#include "mbs/view/parts_page.hpp"

namespace flexura::import {

/// What the page shows of an assembly: its parts with numbered faces, its bodies where the file has them, and the proposed joints.
view::PartsPage page_of(const cad::Assembly& assembly, const cad::Built& built);

}  // namespace flexura::import
