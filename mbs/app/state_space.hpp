// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

/// State-space systems as files.
namespace flexura::app {

struct StateSpace {
  std::string title;  ///< one line: what it is, of which mechanism
  double time = 0.0;
  std::vector<std::pair<std::string, Eigen::MatrixXd>> matrices;        ///< "A", ..., "x_0"
  std::vector<std::pair<std::string, std::vector<std::string>>> names;  ///< "states", "inputs", "outputs"
};

/// By the ending of the path: .m an Octave or MATLAB script, .h5 HDF5 (one dataset for each matrix, the names
/// as text, one a line), .mtx Matrix Market, one file NAME_A.mtx for each matrix (its nonzero entries) with
/// the names as comments.  Returns the files.  The ending is one that state_space_files() takes.
std::vector<std::filesystem::path> write_state_space(const StateSpace& system,
                                                     const std::filesystem::path& path);

/// The files that this may become.  Throws std::invalid_argument for another ending.
std::vector<std::filesystem::path> state_space_files(const std::filesystem::path& path, bool descriptor);

}  // namespace flexura::app
