// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_keywords.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "mesh/import/deck_files.hpp"

namespace flexura::mesh {
namespace {

namespace fs = std::filesystem;

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\""), last = text.find_last_not_of(" \t\r\"");
  return first == std::string_view::npos ? "" : std::string(text.substr(first, last - first + 1));
}

std::vector<std::string> split(std::string_view line) {
  std::vector<std::string> fields;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = line.find(',', begin);
    fields.push_back(trimmed(line.substr(begin, comma - begin)));
    if (comma == std::string_view::npos) break;
    begin = comma + 1;
  }
  while (!fields.empty() && fields.back().empty()) fields.pop_back();
  return fields;
}

constexpr std::size_t most_letters = 100'000;  // of a keyword with all its parameters

/// Whether the last letter is a comma; what follows it is taken away.
bool goes_on(std::string& line) {
  line.erase(line.find_last_not_of(" \t\r") + 1);
  return line.ends_with(',');
}

class KeywordReader {
 public:
  explicit KeywordReader(std::set<std::string>& file_names) : files_(file_names, "*INCLUDE") {}

  void read(const fs::path& path, int depth = 0) {
    std::ifstream file = files_.open(path, depth);
    const std::string* name = files_.name(path);
    std::string line;
    for (int number = 1; std::getline(file, line); ++number) {
      const Where where{name, number};
      line = plain_line(std::move(line), where);
      if (line.rfind("**", 0) == 0 || trimmed(line).empty()) continue;
      if (line[0] != '*') {
        if (keywords.empty()) keywords.push_back({where, "", {}, {}});
        std::vector<std::string> fields = split(line);
        keywords.back().data.push_back({where, std::move(fields), goes_on(line)});
        continue;
      }
      std::string more;
      while (goes_on(line) && std::getline(file, more)) {  // keyword lines go on after a comma
        ++number;
        line += plain_line(std::move(more), where);
        if (line.size() > most_letters)
          throw std::invalid_argument(
              fmt::format("{}: a keyword line of more than {} letters; is the deck damaged?", where.text(),
                          most_letters));
      }
      Keyword keyword{where, "", {}, {}};
      const std::vector<std::string> fields = split(std::string_view(line).substr(1));
      if (fields.empty()) continue;  // a star alone: no keyword
      keyword.name = upper(fields[0]);
      for (std::size_t k = 1; k < fields.size(); ++k) {
        const std::size_t equals = fields[k].find('=');
        keyword.parameters[upper(trimmed(fields[k].substr(0, equals)))] =
            equals == std::string::npos ? "" : trimmed(std::string_view(fields[k]).substr(equals + 1));
      }
      if (keyword.name == "INCLUDE")
        read(path.parent_path() / keyword.get("INPUT"), depth + 1);
      else
        keywords.push_back(std::move(keyword));
    }
  }
  std::vector<Keyword> keywords;

 private:
  DeckFiles files_;
};

}  // namespace

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

double to_real(std::string text, const Where& where) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == 'd' || c == 'D'; }, 'e');
  const char* begin = text.c_str() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
  double value = 0;
  const auto [end, error] = std::from_chars(begin, text.c_str() + text.size(), value);
  if (error != std::errc() || end != text.c_str() + text.size() || !std::isfinite(value))
    throw std::invalid_argument(fmt::format("{}: \"{}\" is not a number", where.text(), text.substr(0, 40)));
  return value;
}

std::optional<std::int64_t> as_integer(const std::string& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

std::int64_t to_integer(const std::string& text, const Where& where) {
  const auto value = as_integer(text);
  if (!value)
    throw std::invalid_argument(
        fmt::format("{}: \"{}\" is not a whole number", where.text(), text.substr(0, 40)));
  return *value;
}

std::vector<Keyword> read_keywords(const fs::path& path, std::set<std::string>& names) {
  KeywordReader reader(names);
  reader.read(path);
  return std::move(reader.keywords);
}

const std::string& field(const Keyword& k, std::size_t line, std::size_t column) {
  if (line >= k.data.size() || column >= k.data[line].fields.size())
    throw std::invalid_argument(fmt::format("{}: *{} wants {} numbers on data line {}", k.where.text(),
                                            k.name, column + 1, line + 1));
  return k.data[line].fields[column];
}

std::vector<DataLine> records(const Keyword& k, std::size_t n) {
  std::vector<DataLine> out;
  bool goes_on = false;
  for (const DataLine& line : k.data) {
    if (goes_on)
      out.back().fields.insert(out.back().fields.end(), line.fields.begin(), line.fields.end());
    else
      out.push_back(line);
    goes_on = line.goes_on && out.back().fields.size() < n;
  }
  return out;
}

std::vector<double> numbers_of(const Keyword& k, std::size_t line) {
  std::vector<double> out;
  if (line < k.data.size())
    for (const std::string& text : k.data[line].fields)
      out.push_back(text.empty() ? 0.0 : to_real(text, k.data[line].where));
  return out;
}

}  // namespace flexura::mesh
