// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "mbs/view/pages.hpp"

namespace flexura::view {

/// The runs for ParaView: for each run STEM.RUN.pvd, which names a file of VTK PolyData for each time in the
/// folder STEM.RUN.  Every body is where it is in the world, flexible ones deformed (not magnified).  Arrays:
/// on points `displacement` (of the deformation alone, in the axes of the world [m]) and, where a
/// superelement has stress modes, `von Mises stress` [Pa]; on cells `body`, its number in the model. At most
/// `most_frames` times of each run, evenly chosen, the last one among them.  Returns the .pvd files. Throws
/// std::invalid_argument as write_motion_page() does, and std::runtime_error when a file cannot be written.
std::vector<std::filesystem::path> write_motion_vtk(const std::filesystem::path& stem,
                                                    const results::Results& results, const Pictures& pictures,
                                                    int most_frames);

}  // namespace flexura::view
