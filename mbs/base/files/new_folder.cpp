// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/new_folder.hpp"

#include <unistd.h>

#include <algorithm>
#include <ranges>
#include <stdexcept>

namespace flexura::files {

namespace fs = std::filesystem;

NewFolder::NewFolder(const fs::path& folder) {
  std::error_code failure, none;
  std::vector<fs::path> missing;
  for (fs::path at = fs::absolute(folder).lexically_normal();
       !at.empty() && !fs::exists(fs::symlink_status(at, none)); at = at.parent_path())
    missing.push_back(at);
  for (const fs::path& at : missing | std::views::reverse)
    if (!failure && fs::create_directory(at, failure)) made_.push_back(at);
  if (fs::is_directory(folder, none)) return;
  for (const fs::path& at : made_ | std::views::reverse) ::rmdir(at.c_str());
  throw std::invalid_argument(folder.string() + ": no folder of this name can be made" +
                              (failure ? ": " + failure.message() : "") + "; name another");
}

NewFolder::~NewFolder() {
  for (const fs::path& at : made_ | std::views::reverse) ::rmdir(at.c_str());
}

bool leads_out_of(const fs::path& folder, const fs::path& path) {
  std::error_code failure;
  const fs::path to = fs::weakly_canonical(fs::absolute(path), failure);
  if (failure) return false;
  const fs::path in = fs::canonical(folder, failure);
  return !failure && std::ranges::mismatch(to, in).in2 != in.end();
}

}  // namespace flexura::files
