// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/results_page.hpp"

#include <fmt/format.h>

namespace flexura::app {

std::string write_results_page(const std::filesystem::path& html, const results::Results& results,
                               const std::filesystem::path& file, const view::MotionPage& page) {
  const view::Pictures pictures = view::read_pictures(results.model, file);
  view::write_motion_page(html, results, pictures, page);
  return fmt::format("{} ({:.1f} MB): open it in a browser", html.string(),
                     static_cast<double>(std::filesystem::file_size(html)) / 1e6);
}

}  // namespace flexura::app
