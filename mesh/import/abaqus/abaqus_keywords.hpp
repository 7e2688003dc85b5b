// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mesh/import/builder.hpp"

/// An Abaqus input file as keywords with their parameters and data lines.
namespace flexura::mesh {

std::string upper(std::string text);
double to_real(std::string text, const Where& where);  ///< throws std::invalid_argument with file and line
std::int64_t to_integer(const std::string& text, const Where& where);
std::optional<std::int64_t> as_integer(const std::string& text);  ///< nothing where it is a name

struct DataLine {
  Where where;
  std::vector<std::string> fields;
  bool goes_on = false;  ///< it ends in a comma
};

/// A keyword line with its parameters and the data lines that follow it.
struct Keyword {
  Where where;
  std::string name;  // upper case, without the star
  std::map<std::string, std::string> parameters;
  std::vector<DataLine> data;
  bool has(const std::string& key) const { return parameters.contains(key); }
  std::string get(const std::string& key) const {
    const auto found = parameters.find(key);
    return found == parameters.end() ? "" : found->second;
  }
};

/// Comments left out, keyword lines joined, *INCLUDE followed; data before the first keyword come as a keyword without name.  `names` keeps file names alive.
std::vector<Keyword> read_keywords(const std::filesystem::path& path, std::set<std::string>& names);

/// An entry of a data line, both counted from 0.  Throws std::invalid_argument where it is not there.
const std::string& field(const Keyword& k, std::size_t line, std::size_t column);
/// The data lines where a record of at least n entries goes on in the next line after a comma; what a line has beyond a
/// comma at its end is no reason to.
std::vector<DataLine> records(const Keyword& k, std::size_t n);
/// The numbers of a data line, 0 for empty entries; none where there is no such line.
std::vector<double> numbers_of(const Keyword& k, std::size_t line);

}  // namespace flexura::mesh
