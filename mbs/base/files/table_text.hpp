// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

/// Texts of files within tables for others.
namespace flexura::files {

/// A field of a CSV table (RFC 4180): one with a comma, a quote or a line break stands in quotes, quotes in it are doubled.
/// Spreadsheets calculate what begins as a formula does: a quote before it makes it a text.
std::string csv_field(std::string_view text);
/// The same, in quotes whatever it holds.
std::string csv_quoted(std::string_view text);

/// In a line or a cell of Markdown: what would be markup, HTML or the end of the cell is none.
std::string markdown_text(std::string_view text);

}  // namespace flexura::files
