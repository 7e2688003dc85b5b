// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/formula_text.hpp"

#include <fmt/format.h>

#include <cctype>
#include <string_view>
#include <vector>

#include "mbs/base/documents/shown_text.hpp"

namespace flexura::input {
namespace {

bool assigns(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    const bool after = i + 1 < text.size() && text[i + 1] == '=';
    const bool before = i > 0 && std::string_view("=<>!").find(text[i - 1]) != std::string_view::npos;
    if (!after && !before) return true;
    if (after) ++i;
  }
  return false;
}

}  // namespace

bool is_name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.';
}

std::string wrong_with_formula(const std::string& text) {
  constexpr std::size_t longest = 10'000;
  if (text.size() > longest)
    return fmt::format("has {} characters, {} are allowed; take a part into a measure", text.size(), longest);
  constexpr std::string_view blanks = " \t\r\n", signs = "+-*/^()<>=!&|?:,";
  std::vector<bool> calls;  // open parentheses: is it a function's?
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool has_meaning = is_name_character(c) || blanks.find(c) != std::string_view::npos ||
                             signs.find(c) != std::string_view::npos;
    if (!has_meaning) {
      std::size_t end = i + 1;
      while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) ++end;
      return fmt::format("\"{}\" has no meaning in a formula", shown_text(text.substr(i, end - i)));
    }
    if (c == '(') {
      const auto before = i == 0 ? std::string::npos : text.find_last_not_of(blanks, i - 1);
      calls.push_back(before != std::string::npos && is_name_character(text[before]));
    } else if (c == ')' && !calls.empty()) {
      calls.pop_back();
    } else if (c == ',' && (calls.empty() || !calls.back())) {
      return "a comma parts the arguments of a function; the decimal sign is a point, like 0.5";
    }
  }
  return assigns(text) ? "a formula must not assign; compare with ==" : "";
}

}  // namespace flexura::input
