// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/nesting.hpp"

#include <algorithm>
#include <vector>

namespace flexura::input {
namespace {

// Where the quoted text that starts at `at` ends: behind its last quote, or at the end of its line (of the
// text, for one of three quotes) where that is missing.
std::size_t after_quotes(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string_view three = quote == '"' ? "\"\"\"" : "'''";
  const bool long_text = text.substr(at).starts_with(three);
  const std::string_view end = long_text ? three : three.substr(0, 1);
  for (std::size_t i = at + end.size(); i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"')
      ++i;
    else if (text[i] == '\n' && !long_text)
      return i;
    else if (text.substr(i).starts_with(end))
      return i + end.size();
  }
  return text.size();
}

}  // namespace

std::optional<int> line_nested_too_deep(std::string_view text) {
  // The header [a.b.c] stays above the keys that follow it; inside of brackets each level has the dots of the
  // key that leads to it.
  int line = 1, header = 0;
  bool in_header = false, line_is_empty = true;
  std::vector<int> above;  // dots of the keys in front of open brackets
  int dots = 0, sum = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      const std::size_t end = after_quotes(text, i);
      line += static_cast<int>(std::count(text.begin() + static_cast<std::ptrdiff_t>(i),
                                          text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      i = end;
      line_is_empty = false;
      continue;
    }
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
      continue;
    }
    ++i;
    if (c == '\n') {
      ++line;
      if (in_header) header = dots;
      if (above.empty() || in_header) {
        above.clear();
        dots = sum = 0;
      }
      in_header = false;
      line_is_empty = true;
      continue;
    }
    if (c == '[' && line_is_empty && above.empty()) {
      in_header = true;
      header = 0;
    } else if (c == '.') {
      ++dots;
    } else if (c == '[' || c == '{') {
      if (!in_header) {
        above.push_back(dots + 1);
        sum += dots + 1;
        dots = 0;
      }
    } else if (c == ']' || c == '}') {
      if (!in_header && !above.empty()) {
        dots = 0;
        sum -= above.back();
        above.pop_back();
      }
    } else if (c == ',') {
      dots = 0;
    }
    if (c != ' ' && c != '\t' && c != '\r') line_is_empty = false;
    if (sum + dots + (in_header ? 0 : header) > deepest_nesting) return line;
  }
  return std::nullopt;
}

}  // namespace flexura::input
