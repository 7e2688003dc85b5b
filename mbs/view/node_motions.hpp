// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "mbs/results/results.hpp"

namespace flexura::view {

/// For each run STEM.RUN.nodes.csv: at at most `most_frames` times, evenly chosen, of each body whose superelement keeps the
/// motions of all nodes (`nodes = "all"` of the part's [recovery]) every node's number, its place in the world [m], and the
/// deformation's displacement [m] and rotation [rad] there in the axes of the body.  The superelements lie where the results
/// file names them.  Returns the files.  Throws std::runtime_error where a superelement is not there or a file cannot be written,
/// std::invalid_argument where no body has them or one is not the superelement that was simulated.
std::vector<std::filesystem::path> write_node_motions(const std::filesystem::path& stem,
                                                      const results::Results& results,
                                                      const std::filesystem::path& results_file,
                                                      int most_frames);

}  // namespace flexura::view
