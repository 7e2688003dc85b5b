// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace flexura::view {

/// Text as it may stand in an element or an attribute; what a browser would obey, or turn the text round it by, is shown
/// (mbs/base/files/plain_text.hpp).
std::string escape_html(std::string_view text);

/// The same of a sentence whose numbers are written as programs do: "1.07e-05" as "1.07\u00b710\u207b\u2075", as in figure_text.  What
/// has no decimal point ("tolerance 1e-7") is the name of something.
std::string sentence_html(std::string_view text);

/// JSON as it may stand in a script element: only "<" can end it or open a comment there, and JSON has
/// another spelling for it, as for what escape_html() shows.
std::string escape_script(std::string_view json);

/// Digits an engineer reads, in HTML: n significant ones, thin spaces between thousands from 10,000 on,
/// powers of ten beyond 0.001 and 1,000,000; a dash for what is not a number.
std::string figure_text(double value, int digits);

/// "kg*m^2" as it is printed: kg·m².
std::string unit_text(std::string_view unit);

}  // namespace flexura::view
