// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/table_text.hpp"

#include "mbs/base/files/plain_text.hpp"

namespace flexura::files {

namespace {

std::string no_formula(std::string_view text) {
  constexpr std::string_view begins = "=+-@\t\r";
  const bool is_formula = !text.empty() && begins.find(text.front()) != std::string_view::npos;
  return (is_formula ? "'" : "") + std::string(text);
}

}  // namespace

std::string csv_quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : no_formula(text)) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_field(std::string_view text) {
  return text.find_first_of(",\"\n\r") == std::string_view::npos ? no_formula(text) : csv_quoted(text);
}

std::string markdown_text(std::string_view text) {
  constexpr std::string_view markup = "\\`*[]<>|&~";
  std::string out;
  for (const char c : plain_text(text)) {
    if (markup.find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

}  // namespace flexura::files
