// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/left_behind.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "mbs/base/files/inputs.hpp"

namespace flexura::files {
namespace {

namespace fs = std::filesystem;

bool begins_with(const fs::path& file, std::string_view opening) {
  std::ifstream in(file, std::ios::binary);
  std::string head(opening.size(), ' ');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  return opening.empty() ? in.peek() == std::char_traits<char>::eof() : in.gcount() == 0 || head == opening;
}

}  // namespace

bool is_private_name(std::string_view name, std::string_view file) {
  constexpr std::string_view kEnding = ".part";
  if (!name.starts_with(file) || !name.ends_with(kEnding) || name.size() < file.size() + kEnding.size())
    return false;
  name = name.substr(file.size(), name.size() - file.size() - kEnding.size());
  return name.empty() ||
         (name.size() > 1 && name[0] == '.' &&
          std::ranges::all_of(name.substr(1), [](char c) { return (c >= '0' && c <= '9') || c == '-'; }));
}

std::vector<fs::path> private_files(const fs::path& place, std::string_view opening) {
  std::error_code none;
  std::vector<fs::path> found;
  for (fs::directory_iterator entry(place.parent_path(), none), end; !none && entry != end;
       entry.increment(none))
    if (is_private_name(entry->path().filename().string(), place.filename().string()) &&
        fs::is_regular_file(entry->symlink_status(none)) && begins_with(entry->path(), opening))
      found.push_back(entry->path());
  return found;
}

void remove_left_behind(const fs::path& output, std::string_view opening) {
  std::error_code none;
  for (const fs::path& file : private_files(fs::weakly_canonical(output, none), opening))
    if (!input_like(file)) fs::remove(file, none);
}

}  // namespace flexura::files
