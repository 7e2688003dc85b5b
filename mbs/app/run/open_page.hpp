// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "mbs/solver/start/not_assembled.hpp"

namespace flexura::app {

/// A page of a mechanism that does not assemble, where its loops are open the least: both sides of every open
/// joint as red balls with their axes, joined by a red line, and how far they are apart among the quantities.
/// Throws what write_motion_page() throws.
void write_open_page(const std::filesystem::path& html, const mbs::NotAssembled& failure,
                     const std::filesystem::path& mechanism_file);

}  // namespace flexura::app
