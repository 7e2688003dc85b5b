// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/table_names.hpp"

#include "mbs/base/documents/toml_file.hpp"

namespace flexura::input {

std::vector<std::string> names_in_table(const std::filesystem::path& file, const std::string& table) {
  std::vector<std::string> names;
  const toml::table root = read_toml(file);
  if (const toml::table* const found = root[table].as_table())
    for (const auto& [name, value] : *found) names.emplace_back(name.str());
  return names;
}

}  // namespace flexura::input
