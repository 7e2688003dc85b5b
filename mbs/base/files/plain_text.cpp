// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/plain_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace flexura::files {
namespace {

struct Range {
  char32_t first, last;
};

// Beside letters, marks and symbols.  Joiners of letters (U+200C, U+200D) belong to scripts and pictures.
constexpr std::array kHarmful = {
    Range{0x00, 0x1F},     Range{0x7F, 0x9F},       // control characters
    Range{0x061C, 0x061C}, Range{0x200E, 0x200F},   // directions
    Range{0x202A, 0x202E}, Range{0x2066, 0x206F},   //
    Range{0x2028, 0x2029},                          // separators of lines and paragraphs
    Range{0xFEFF, 0xFEFF},                          // mark of byte order
    Range{0xFFF9, 0xFFFB}, Range{0xE0000, 0xE007F}  // annotations, tags
};

}  // namespace

bool is_harmful(char32_t code) {
  return std::ranges::any_of(kHarmful, [&](const Range& r) { return code >= r.first && code <= r.last; });
}

Letter first_letter(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char head = byte(0);
  if (head < 0x80) return {1, head, true};
  const std::size_t size = head >= 0xC2 && head < 0xE0   ? 2
                           : head >= 0xE0 && head < 0xF0 ? 3
                           : head >= 0xF0 && head < 0xF5 ? 4
                                                         : 0;
  if (size == 0) return {1, head};
  char32_t code = head & (0x7FU >> size);
  for (std::size_t k = 1; k < size; ++k) {
    if (k == text.size()) return {1, head, false, true};
    if ((byte(k) & 0xC0U) != 0x80U) return {1, head};
    code = code << 6 | (byte(k) & 0x3FU);
  }
  constexpr std::array<char32_t, 5> least = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_code = code >= least[size] && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF);
  return is_code ? Letter{size, code, true} : Letter{1, head};
}

std::string escaped(char32_t code, bool is_whole) {
  const auto value = static_cast<unsigned>(code);
  if (!is_whole || value < 0x20) return fmt::format("\\x{:02x}", value);
  if (value < 0x10000) return fmt::format("\\u{:04x}", value);
  return fmt::format("\\u{:04x}\\u{:04x}", 0xD800 + ((value - 0x10000) >> 10),
                     0xDC00 + ((value - 0x10000) & 0x3FF));
}

std::string harmless_text(std::string_view text, LineFeeds line_feeds) {
  std::string out;
  while (!text.empty()) {
    const Letter letter = first_letter(text);
    if (letter.code == '\n' && line_feeds == LineFeeds::kept)
      out += '\n';
    else if (letter.code == '\n' && line_feeds == LineFeeds::escaped)
      out += "\\n";
    else if (letter.code == '\n' || letter.code == '\t' ||
             (letter.code == '\r' && line_feeds == LineFeeds::blank))
      out += ' ';
    else if (!letter.is_whole || is_harmful(letter.code))
      out += escaped(letter.code, letter.is_whole);
    else
      out += text.substr(0, letter.size);
    text.remove_prefix(letter.size);
  }
  return out;
}

bool is_plain_text(std::string_view text) {
  while (!text.empty()) {
    const Letter letter = first_letter(text);
    if (!letter.is_whole || is_harmful(letter.code)) return false;
    text.remove_prefix(letter.size);
  }
  return true;
}

}  // namespace flexura::files
