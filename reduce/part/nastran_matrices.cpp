// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/nastran_matrices.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "reduce/part/text_lines.hpp"

namespace flexura::reduce {
namespace {

std::string trimmed(std::string text) {
  const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
  text.erase(std::find_if_not(text.rbegin(), text.rend(), blank).base(), text.end());
  text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), blank));
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// One line of bulk data: its name (empty: it continues the card before) and its fields, eight or four.
struct Line {
  std::string name;
  std::vector<std::string> fields;
};

Line split(const std::string& text) {
  Line line;
  std::string first;
  if (text.find(',') != std::string::npos) {
    std::size_t at = text.find(',');
    first = trimmed(text.substr(0, at));
    while (at != std::string::npos) {
      const std::size_t next = text.find(',', at + 1);
      line.fields.push_back(trimmed(text.substr(at + 1, next == std::string::npos ? next : next - at - 1)));
      at = next;
    }
  } else {
    first = trimmed(text.substr(0, 8));
    const std::size_t width = first.find('*') != std::string::npos ? 16 : 8;
    for (std::size_t at = 8; at < 72; at += width)
      line.fields.push_back(at < text.size() ? trimmed(text.substr(at, width)) : "");
  }
  line.fields.resize(first.find('*') != std::string::npos ? 4 : 8);  // a ninth names the continuation
  if (!first.empty() && std::isalpha(static_cast<unsigned char>(first.front())) != 0)
    line.name = first.substr(0, first.find('*'));
  return line;
}

/// "1.5D+3", "1.5+3".
double real(const std::string& text, const Lines& lines) {
  std::string number;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const bool sign = text[k] == '+' || text[k] == '-';
    if (sign && k > 0 && std::isalpha(static_cast<unsigned char>(text[k - 1])) == 0) number += 'E';
    number += text[k] == 'D' ? 'E' : text[k];
  }
  char* end = nullptr;
  const double value = std::strtod(number.c_str(), &end);
  if (number.empty() || *end != '\0' || !std::isfinite(value))
    lines.refuse(fmt::format("\"{}\" is no finite number; write 1.5, 1.5E-3, 1.5D-3 or 1.5-3", text));
  return value;
}

std::int64_t integer(const std::string& text, const Lines& lines) {
  char* end = nullptr;
  const std::int64_t value = std::strtoll(text.c_str(), &end, 10);
  if (text.empty() || *end != '\0')
    lines.refuse(fmt::format("\"{}\" is no whole number; give a grid or a component", text));
  return value;
}

bool is_comment(const std::string& line) {
  return line.empty() || line.front() == '$';
}

/// The names of all matrices, as their first cards (grid 0) give them.
std::vector<std::string> names_in(const std::filesystem::path& path) {
  std::vector<std::string> names;
  Lines lines(path);
  for (std::string text; lines.next(text);) {
    if (is_comment(text) || std::toupper(static_cast<unsigned char>(text.front())) != 'D') continue;
    const Line line = split(text);
    if (line.name == "DMIG" && line.fields[1] == "0" &&
        std::ranges::find(names, line.fields[0]) == names.end())
      names.push_back(line.fields[0]);
  }
  return names;
}

std::string chosen_name(const std::filesystem::path& path, char letter) {
  const std::vector<std::string> names = names_in(path);
  if (names.empty())
    throw std::invalid_argument(
        path.string() +
        ": holds no DMIG matrix with its first card; let it begin with DMIG, NAME, 0, form, types");
  if (names.size() == 1) return names.front();
  std::vector<std::string> fit;
  for (const std::string& name : names)
    if (name.starts_with(letter) && !name.starts_with("K4")) fit.push_back(name);
  if (fit.size() != 1)
    throw std::invalid_argument(
        fmt::format("{}: {} of its DMIG matrices ({}) begin with {}, one is wanted; put the one that is "
                    "meant into a file of "
                    "its own",
                    path.string(), fit.size(), fmt::join(names, ", "), letter));
  return fit.front();
}

}  // namespace

bool is_nastran_text(const std::filesystem::path& path) {
  Lines lines(path);
  for (std::string text; lines.next(text);)
    if (const std::string begin = trimmed(text); !is_comment(begin))
      return std::isalpha(static_cast<unsigned char>(begin.front())) != 0;
  return false;
}

void read_dmig(const std::filesystem::path& path, char letter,
               const std::function<void(const DmigEntry&)>& take) {
  const std::string name = chosen_name(path, letter);
  Lines lines(path);
  bool inside = false;  // of a column of this matrix
  DmigEntry entry{};
  const auto component = [&](const std::string& text) {
    const std::int64_t c = text.empty() ? 0 : integer(text, lines);
    if (c < 0 || c > 6) lines.refuse(fmt::format("component {} must be one of 0 to 6", c));
    return static_cast<int>(c);
  };
  for (std::string text; lines.next(text);) {
    if (is_comment(text) || trimmed(text).empty()) continue;
    const Line line = split(text);
    std::size_t first = 0;  // field of the first row
    if (!line.name.empty()) {
      inside = line.name == "DMIG" && line.fields[0] == name;
      if (!inside) continue;
      if (line.fields[1] == "0") {
        const std::int64_t form = integer(line.fields[2], lines), type = integer(line.fields[3], lines);
        if (form != 1 && form != 6)
          lines.refuse(
              fmt::format("matrix {} has the form {}; 6 (symmetric) or 1 (square) is wanted", name, form));
        if (type != 1 && type != 2)
          lines.refuse(
              fmt::format("matrix {} is of type {}, complex; 1 or 2 (real) is wanted: structural damping as "
                          "a matrix of its own",
                          name, type));
        inside = false;
        continue;
      }
      entry.point[1] = integer(line.fields[1], lines);
      entry.component[1] = component(line.fields[2]);
      first = 4;
    } else if (!inside) {
      continue;
    }
    for (; first + 3 < line.fields.size(); first += 4) {
      if (line.fields[first].empty()) continue;
      entry.point[0] = integer(line.fields[first], lines);
      entry.component[0] = component(line.fields[first + 1]);
      entry.value = real(line.fields[first + 2], lines);
      entry.line = lines.number();
      take(entry);
    }
  }
}

}  // namespace flexura::reduce
