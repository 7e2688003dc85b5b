// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "beam/section/solver.hpp"
#include "mbs/base/documents/schema.hpp"

/// The file that `flexura section` writes and a beam part reads.
namespace flexura::reduce {

/// A TOML file for `type = "file"` in a beam part: stiffness and mass, what warnings need, stress points,
/// outline.
std::string section_result(const beam::SectionProperties& properties);

/// Schema of such a file.
const input::TableSchema& section_result_schema();

/// Reads it back.  Throws input::InputError for files that are no such thing, and for matrices that no
/// section has.  `outline_stress`: is given the stresses at the outline's points, none where the file has none.
beam::Section read_section_result(const std::string& name, const std::filesystem::path& file,
                                  std::vector<Eigen::Matrix<double, 3, 6>>* outline_stress = nullptr);

}  // namespace flexura::reduce
