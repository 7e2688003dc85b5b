// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/toml_file.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/nesting.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/documents/units.hpp"
#include "mbs/base/files/inputs.hpp"

namespace flexura::input {
namespace {

std::string read_text(const std::filesystem::path& file) {
  std::error_code failure;
  const auto status = std::filesystem::status(file, failure);
  if (!std::filesystem::exists(status)) {
    std::vector<std::string> neighbours;
    const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
    for (std::filesystem::directory_iterator it(folder, failure), end; !failure && it != end;
         it.increment(failure)) {
      if (it->path().extension() == ".toml") neighbours.push_back(it->path().filename().string());
    }
    const std::string near = nearest(file.filename().string(), neighbours);
    throw InputError(file.string() + ": there is no such file" +
                     (near.empty() ? "; check the path" : ", did you mean \"" + near + "\"?"));
  }
  if (std::filesystem::is_directory(status))
    throw InputError(file.string() + ": is a folder, a TOML file is wanted");
  files::note_input(file);
  // A value of two letters takes more than a hundred bytes.
  constexpr std::uintmax_t most = 50'000'000;
  if (const std::uintmax_t size = std::filesystem::file_size(file, failure); !failure && size > most)
    throw InputError(fmt::format(
        "{}: has {} bytes, of a TOML file {} are taken; write tables of numbers into files of their own",
        file.string(), size, most));
  std::ifstream in(file, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in) throw InputError(file.string() + ": cannot be read; check its permissions");
  if (text.starts_with("\x89HDF"))
    throw InputError(file.string() + ": is an HDF5 file, a TOML file is wanted");
  return text;
}

}  // namespace

toml::table read_toml(const std::filesystem::path& file) {
  return parse_toml(read_text(file), file.string());
}

toml::table parse_toml(const std::string& text, const std::string& name) {
  if (const auto line = line_nested_too_deep(text))
    throw InputError(fmt::format("{}:{}: nests deeper than {} tables and lists; no key of ours lies there",
                                 name, *line, deepest_nesting));
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& failure) {
    throw InputError(fmt::format("{}:{}:{}: is not valid TOML: {}", name, failure.source().begin.line,
                                 failure.source().begin.column, shown_text(failure.description(), 200)));
  }
}

}  // namespace flexura::input
