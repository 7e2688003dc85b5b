// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace flexura::view {

/// The bundle was there when the program was built; without it the texts below are empty.
bool has_pages();
/// What is missing without it, and what to do.
extern const char* const kNoPages;
/// Throws std::runtime_error where a page cannot be written for want of it.
void require_pages();

/// The bundled script of the pages that draw (web/src with three.js and uPlot), and their style sheet.
std::string_view page_script();
std::string_view page_style();

/// The same for report pages, which need neither library.
std::string_view report_script();
std::string_view report_style();

}  // namespace flexura::view
