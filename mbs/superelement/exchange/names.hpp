// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace flexura::superelement {

/// STEM.K.mtx of write_matrix_market().
std::filesystem::path matrix_market_name(const std::filesystem::path& stem, const std::string& letter);

}  // namespace flexura::superelement
