// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "mbs/results/results.hpp"
#include "mbs/view/pages.hpp"

namespace flexura::app {

/// The page on which the runs of `results`, read from `file`, move; "HTML (SIZE MB): open it in a browser".  Throws what
/// view::read_pictures() and view::write_motion_page() throw.
std::string write_results_page(const std::filesystem::path& html, const results::Results& results,
                               const std::filesystem::path& file, const view::MotionPage& page = {});

}  // namespace flexura::app
