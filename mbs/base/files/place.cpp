// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/place.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

namespace flexura::files {
namespace {

namespace fs = std::filesystem;

// More links than Linux itself follows.
constexpr int kMostLinks = 40;

fs::path without_links(const fs::path& output) {
  fs::path at = fs::absolute(output);
  std::error_code none;
  for (int links = 0; fs::is_symlink(fs::symlink_status(at, none)); ++links) {
    if (links == kMostLinks)
      throw std::invalid_argument(fmt::format(
          "{}: is a symbolic link that leads back to itself; name another output", output.string()));
    const fs::path to = fs::read_symlink(at);
    at = to.is_absolute() ? to : at.parent_path() / to;
  }
  return at;
}

void require_folder(const fs::path& output, const fs::path& folder, const std::string& shown) {
  std::error_code failure;
  const fs::file_status status = fs::status(folder, failure);
  if (fs::is_directory(status)) return;
  if (fs::exists(status))
    throw std::invalid_argument(
        fmt::format("{}: {} is a file, not a folder; name another output", output.string(), shown));
  if (status.type() == fs::file_type::not_found)
    throw std::invalid_argument(
        fmt::format("{}: the folder {} does not exist; make it first", output.string(), shown));
  throw std::invalid_argument(
      fmt::format("{}: the folder {} cannot be reached: {}", output.string(), shown, failure.message()));
}

std::string size_text(double bytes) {
  return bytes < 1e6   ? fmt::format("{:.3g} kB", bytes / 1e3)
         : bytes < 1e9 ? fmt::format("{:.3g} MB", bytes / 1e6)
                       : fmt::format("{:.3g} GB", bytes / 1e9);
}

}  // namespace

std::optional<Identity> identity_of(const fs::path& file) {
  struct stat info {};
  if (::stat(file.c_str(), &info) != 0) return std::nullopt;
  return Identity{info.st_dev, info.st_ino};
}

fs::path place_of(const fs::path& output) {
  const fs::path at = without_links(output), name = at.filename(), folder = at.parent_path();
  if (name.empty() || name == "." || name == "..")
    throw std::invalid_argument(
        fmt::format("{}: is a folder; name a file in it as the output", output.string()));
  require_folder(output, folder, output.has_parent_path() ? output.parent_path().string() : folder.string());
  std::error_code none;
  const fs::file_status status = fs::status(at, none);
  if (fs::is_directory(status))
    throw std::invalid_argument(
        fmt::format("{}: is a folder; name a file in it as the output", output.string()));
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw std::invalid_argument(fmt::format(
        "{}: is a device or a pipe, where no file can be put; name a file as the output", output.string()));
  // A folder from elsewhere may hold a link under the name of an output: it must not lead to a file of another kind.
  if (fs::is_symlink(fs::symlink_status(output, none)) && fs::exists(status) &&
      at.extension() != output.extension() &&
      folder != without_links(output.parent_path() / ".").parent_path())
    throw std::invalid_argument(fmt::format(
        "{}: is a link to {}, a file of another kind, which would be replaced; take the link away or name "
        "another output",
        output.string(), at.string()));
  // root may write everything; a file without any right to write is meant to stay as it is all the same.
  constexpr auto to_write = fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
  if (fs::exists(status) &&
      ((status.permissions() & to_write) == fs::perms::none || ::access(at.c_str(), W_OK) != 0))
    throw std::invalid_argument(fmt::format(
        "{}: is read-only and would be replaced; name another output or give the right to write (chmod u+w)",
        output.string()));
  return fs::canonical(folder) / name;
}

void require_stem(const fs::path& stem) {
  const fs::path name = stem.filename();
  if (name.empty() || name == "." || name == "..")
    throw std::invalid_argument(
        fmt::format("{}: is a folder; name files in it by how their names are to begin, as in {}",
                    stem.string(), (stem / "engine").string()));
  std::error_code none;
  const fs::file_status status = fs::status(stem, none);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
    throw std::invalid_argument(fmt::format(
        "{}: is a device or a pipe, no beginning of the names of files; name another output", stem.string()));
}

void require_room(const fs::path& output, const fs::path& folder, double bytes) {
  struct statvfs info {};
  if (::statvfs(folder.c_str(), &info) == 0 && info.f_blocks > 0) {
    const double free = static_cast<double>(info.f_bavail) * static_cast<double>(info.f_frsize);
    if (free < bytes)
      throw std::runtime_error(
          fmt::format("{}: about {} are expected, and {} are free in {}; free some room or name an output "
                      "on another disk",
                      output.string(), size_text(bytes), size_text(free), folder.string()));
  }
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      static_cast<double>(limit.rlim_cur) < bytes)
    throw std::runtime_error(
        fmt::format("{}: about {} are expected, and files may have {} here; raise the limit (ulimit -f)",
                    output.string(), size_text(bytes), size_text(static_cast<double>(limit.rlim_cur))));
}

}  // namespace flexura::files
