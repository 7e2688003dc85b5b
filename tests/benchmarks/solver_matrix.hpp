// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// The stiffness matrices by which solver packages are compared.
namespace flexura::reduce {

/// The upper triangle by rows (columns ascend, the diagonal first), and the rows of one node as groups.
struct SolverMatrix {
  std::vector<int> row_begin, columns, group_begin;
  std::vector<double> values;
  int size() const { return static_cast<int>(row_begin.size()) - 1; }
};

void write(const std::filesystem::path& file, const SolverMatrix& A);
SolverMatrix read_matrix(const std::filesystem::path& file);

/// K_ii of a part of steel in ten-node tetrahedra, held at two interfaces: "slender" (a bar, 20 mm x 20 mm x 1 m), "thin"
/// (a plate, 400 mm x 400 mm x 2 mm), "shell-like" (a slit tube, diameter 200 mm, length 300 mm, wall 2 mm); the
/// interior of PART.toml (CAD) at a mesh size for "PART.toml SIZE".
SolverMatrix stiffness_of(const std::string& part, const std::string& size);

}  // namespace flexura::reduce
