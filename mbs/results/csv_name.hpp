// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace flexura::results {

/// The table of one run beside the results: engine.h5 gives engine.RUN.csv.
std::filesystem::path csv_name(const std::filesystem::path& path, const std::string& run);

}  // namespace flexura::results
