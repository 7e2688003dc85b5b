// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace flexura::view {

/// The bundled script of all pages (web/src with three.js and uPlot), and their style sheet.
std::string_view page_script();
std::string_view page_style();

}  // namespace flexura::view
