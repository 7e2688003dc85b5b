// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// Texts of files (titles, names, words that are shown) without what acts on whoever shows them.
///
/// Harmful are control characters (C0, DEL, C1: a terminal obeys them, a line feed begins another line of a table, a comment or a
/// script), characters that turn or hide the text around them (directions, tags, annotations, separators of lines, marks of byte
/// order) and bytes that are no UTF-8, as an 8-bit terminal obeys 0x9b.
namespace flexura::files {

/// What becomes of line feeds; blank: of tabs and carriage returns, too.
enum class LineFeeds { kept, blank, escaped };

/// `text` with harmful characters as "\x1b" (C0, bytes that are no UTF-8) and "\u009b" (the others, as JSON writes them).  Tabs
/// become blanks.  Applied again, nothing changes.
std::string harmless_text(std::string_view text, LineFeeds line_feeds);

/// A title or a name as it is read from a file: harmless and on one line.  Readers of all formats apply it to what they read.
inline std::string plain_text(std::string_view text) {
  return harmless_text(text, LineFeeds::blank);
}

/// Whether plain_text() leaves it as it is.
bool is_plain_text(std::string_view text);

/// One character of UTF-8.
struct Letter {
  std::size_t size = 1;  ///< bytes
  char32_t code = 0;
  bool is_whole =
      false;  ///< otherwise a byte that is no UTF-8, or the beginning of a character that the text cuts short
  bool is_cut = false;  ///< the latter
};

/// The first character of a text that is not empty.
Letter first_letter(std::string_view text);

bool is_harmful(char32_t code);

/// Of a harmful character, or of a byte that is no UTF-8.
std::string escaped(char32_t code, bool is_whole);

}  // namespace flexura::files
