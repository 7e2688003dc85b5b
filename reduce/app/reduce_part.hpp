// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "reduce/app/part_file.hpp"
#include "reduce/linalg/team.hpp"

namespace flexura::reduce {

struct OutputOptions {
  std::filesystem::path report;  ///< JSON report beside the superelement; empty = only inside it
  std::filesystem::path mesh;    ///< the mesh for other programs (write_mesh.hpp); empty = not written
  int compare = 0;  ///< free frequencies to compare with the full model, which is solved, too; 0: none
  const linalg::Team* team = nullptr;  ///< of processes that share the work; null: this one alone
  std::vector<linalg::UserOption> petsc = {};  ///< options of PETSc and SLEPc, after those of the part file
  bool factor_in_file = false;         ///< the factor goes to a temporary file even where memory has room
  bool quiet = false;
};

/// The whole road from a part file to a superelement: mesh, choose interfaces, tie, reduce, check, write.
/// Throws std::invalid_argument for what the user can mend, std::runtime_error otherwise; `output` is written
/// whole or not at all.
void reduce_part(const PartInput& part, const std::filesystem::path& output, const OutputOptions& options);

}  // namespace flexura::reduce
