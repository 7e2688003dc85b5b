// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/msh_file.hpp"

#include <array>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace flexura::mesh {

bool begins_as_msh(const std::filesystem::path& file) {
  std::array<char, 12> head{};
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), head.size());
  const std::string_view begin(head.data(), static_cast<std::size_t>(in.gcount()));
  return begin.starts_with("$MeshFormat") || begin.starts_with("$Comments");  // which may stand before it
}

void inspect_msh_file(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw std::invalid_argument(name + ": no such file");
  std::ifstream file(path, std::ios::binary);
  if (!std::filesystem::is_regular_file(path, error) || !file)
    throw std::invalid_argument(name + ": cannot be opened as a file");
  if ((file >> std::ws).eof()) throw std::invalid_argument(name + ": is empty");
  if (!begins_as_msh(path))
    throw std::invalid_argument(name +
                                ": not a gmsh mesh (it does not begin with $MeshFormat); save it as MSH");
}

}  // namespace flexura::mesh
