// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/shown_text.hpp"

#include "mbs/base/files/plain_text.hpp"

namespace flexura::input {
namespace {

constexpr std::size_t longest_message = 400;

// Inside of a character of UTF-8, where nothing may be cut.
bool goes_on(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

std::string cut(std::string_view text, std::size_t longest, std::size_t kept_at_end) {
  if (text.size() <= longest) return std::string(text);
  constexpr std::string_view gap = "...";
  std::size_t head = longest - kept_at_end - gap.size(), tail = text.size() - kept_at_end;
  while (head > 0 && goes_on(text[head])) --head;
  while (tail < text.size() && goes_on(text[tail])) ++tail;
  return std::string(text.substr(0, head)) + std::string(gap) + std::string(text.substr(tail));
}

}  // namespace

std::string shown_text(std::string_view text, std::size_t longest) {
  // Cut before and after: a control character takes four.
  return cut(files::harmless_text(cut(text, longest, longest / 4), files::LineFeeds::escaped), longest,
             longest / 4);
}

std::string shown_message(std::string_view message) {
  constexpr std::size_t remedy = 160;  // which ends the sentence
  return cut(files::harmless_text(cut(message, 4 * longest_message, 2 * remedy), files::LineFeeds::escaped),
             longest_message, remedy);
}

}  // namespace flexura::input
