// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/table_names.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <fstream>
#include <sstream>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/nesting.hpp"
#include "mbs/base/files/inputs.hpp"

namespace flexura::input {

std::vector<std::string> names_in_table(const std::filesystem::path& file, const std::string& table) {
  files::note_input(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(fmt::format("{}: cannot be read; check its path and permissions", file.string()));
  std::ostringstream text;
  text << in.rdbuf();
  if (const auto line = line_nested_too_deep(text.str()))
    throw InputError(
        fmt::format("{}:{}: nests too deep; write fewer brackets within each other", file.string(), *line));
  std::vector<std::string> names;
  try {
    const toml::table root = toml::parse(text.str());
    if (const toml::table* const found = root[table].as_table())
      for (const auto& [name, value] : *found) names.emplace_back(name.str());
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}: {}", file.string(), error.source().begin.line, error.description()));
  }
  return names;
}

}  // namespace flexura::input
