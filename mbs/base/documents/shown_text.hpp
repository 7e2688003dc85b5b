// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// What a message may show of a text that a user gave: a file is not to be read in an error, nor to move the
/// terminal's cursor.
namespace flexura::input {

/// `text` on one line, control characters as "\x1b", what is longer than `longest` bytes cut in the middle
/// (never within a character of UTF-8): begin and end tell more than the begin alone.
std::string shown_text(std::string_view text, std::size_t longest = 72);

/// A whole message for the terminal, one sentence on one line: at most 400 bytes, control characters as above.
std::string shown_message(std::string_view message);

}  // namespace flexura::input
