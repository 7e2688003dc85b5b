// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "reduce/library/reduce.hpp"

namespace flexura::reduce {

struct OutputOptions {
  std::filesystem::path report;        ///< JSON report beside the superelement; empty = only inside it
  std::filesystem::path mesh;          ///< the mesh for other programs (write_mesh.hpp); empty = not written
  int compare = 0;                     ///< ReduceOptions::compare
  const linalg::Team* team = nullptr;  ///< ReduceOptions::team
  std::vector<linalg::UserOption> petsc = {};  ///< ReduceOptions::petsc
  bool factor_in_file = false;                 ///< ReduceOptions::factor_in_file
  bool quiet = false;
};

/// Reduces with progress on the terminal, writes the superelement, its report and its mesh, and prints what there is to say.
/// `output` is written whole or not at all; a good superelement there is not replaced by one whose mesh does not resolve its
/// part (std::runtime_error).  Where an accuracy asked for is not reached, that is a warning, and the
/// verdict says what is.  Throws like reduce().
void reduce_to_file(const PartInput& part, const std::filesystem::path& output, const OutputOptions& options);
void reduce_to_file(const BeamPartInput& part, const std::filesystem::path& output,
                    const OutputOptions& options);
void reduce_to_file(const FlexDataInput& part, const std::filesystem::path& output,
                    const OutputOptions& options);

}  // namespace flexura::reduce
