// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/html/html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <regex>

#include "mbs/base/files/plain_text.hpp"

namespace flexura::view {

std::string escape_html(std::string_view text) {
  std::string result;
  for (const char c : files::harmless_text(text, files::LineFeeds::kept)) {
    switch (c) {
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '&':
        result += "&amp;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string escape_script(std::string_view json) {
  std::string result;
  result.reserve(json.size());
  for (std::size_t size = 1; !json.empty(); json.remove_prefix(size)) {
    const auto c = static_cast<unsigned char>(json.front());
    size = 1;
    if (c == '<') {
      result += "\\u003c";
    } else if (c < 0x7F) {
      result += json.front();
    } else {
      const files::Letter letter = files::first_letter(json);
      size = letter.size;
      if (!letter.is_whole)
        result += "\\ufffd";
      else if (files::is_harmful(letter.code))
        result += files::escaped(letter.code, true);
      else
        result += json.substr(0, size);
    }
  }
  return result;
}

namespace {

constexpr const char* minus = "\u2212";
constexpr const char* thin_space = "\u2009";

std::string raised(int number) {
  static constexpr const char* digits[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                           "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string text;
  for (const char c : fmt::format("{}", number)) text += c == '-' ? "\u207b" : digits[c - '0'];
  return text;
}

/// Without zeros at the end of what stands behind the point.
std::string trimmed(std::string number) {
  if (number.find('.') == std::string::npos) return number;
  number.erase(number.find_last_not_of('0') + 1);
  if (number.back() == '.') number.pop_back();
  return number;
}

}  // namespace

std::string sentence_html(std::string_view text) {
  static const std::regex number("([0-9]+\\.[0-9]+)e([+-]?[0-9]+)");
  const std::string escaped = escape_html(text);
  std::string result;
  auto from = escaped.cbegin();
  for (std::sregex_iterator found(escaped.begin(), escaped.end(), number), end; found != end; ++found) {
    result.append(from, (*found)[0].first);
    result += found->str(1) + "\u00b710" + raised(std::stoi(found->str(2)));
    from = (*found)[0].second;
  }
  return result.append(from, escaped.cend());
}

std::string figure_text(double value, int digits) {
  if (std::isnan(value)) return "\u2013";
  if (std::isinf(value)) return value > 0.0 ? "\u221e" : std::string(minus) + "\u221e";
  if (value == 0.0) return "0";
  digits = std::max(1, digits);
  // The exponent after rounding: 999.99 with three digits is 1.00e+03.
  const std::string scientific = fmt::format("{:.{}e}", std::abs(value), digits - 1);
  const auto e = scientific.find('e');
  const int exponent = std::stoi(scientific.substr(e + 1));
  const std::string sign = value < 0.0 ? minus : "";
  if (exponent >= 6 || exponent < -3) {
    return fmt::format("{}{}·10{}", sign, trimmed(scientific.substr(0, e)), raised(exponent));
  }
  std::string text = trimmed(fmt::format("{:.{}f}", std::abs(value), std::max(0, digits - 1 - exponent)));
  const auto whole = std::min(text.find('.'), text.size());
  if (whole > 4) {
    for (std::size_t at = whole; at > 3;) {
      at -= 3;
      text.insert(at, thin_space);
    }
  }
  return sign + text;
}

std::string unit_text(std::string_view unit) {
  std::string text;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    if (unit[i] == '*') {
      text += "·";
    } else if (unit[i] == '^' && i + 1 < unit.size() && (unit[i + 1] == '2' || unit[i + 1] == '3')) {
      text += unit[++i] == '2' ? "²" : "³";
    } else {
      text += unit[i];
    }
  }
  return escape_html(text);
}

}  // namespace flexura::view
