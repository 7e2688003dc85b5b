// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mesh/gmsh/job.hpp"

/// Jobs and results as texts (JSON), in a file of their own: JSON's templates take a second in every file that sees them.
namespace flexura::mesh {

std::string text_of(const Job& job);
/// Bytes that are no UTF-8, as names in a CAD file may be, are replaced.
std::string text_of(const ResultRecord& result);
/// Throw std::invalid_argument where the text is no JSON or lacks something.
Job read_job(const std::string& text);
ResultRecord read_result(const std::string& text);

}  // namespace flexura::mesh
