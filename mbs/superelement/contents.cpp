// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/contents.hpp"

#include <map>
#include <mutex>

#include "mbs/base/hdf5/file.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::superelement {
namespace {

Contents read_contents(const std::filesystem::path& path) {
  Contents out{read(path, {.matrices = false, .inertia = false}), {}, false};
  const hdf5::File file(path, hdf5::Mode::read);
  const hdf5::Group root = file.root();
  const auto size = [&](const std::string& part) {
    double sum = 0.0;
    if (!root.has(part)) return sum;
    const hdf5::Group group = root.group(part);
    for (const std::string& name : group.names()) {
      double entries = sizeof(double);
      for (const std::size_t extent : group.shape(name)) entries *= static_cast<double>(extent);
      sum += entries;
    }
    return sum;
  };
  out.bytes = {size("matrices"), size("inertia"), size("stiffening"),
               size("surface"),  size("shapes"),  size("stress")};
  out.stiffening_of_loads = root.has("stiffening") && root.group("stiffening").has("K0p");
  return out;
}

// A file as it was when it was read.
struct Known {
  std::filesystem::file_time_type written;
  std::uintmax_t size = 0;
  Contents contents;
};

}  // namespace

Contents contents(const std::filesystem::path& path) {
  static std::mutex mutex;
  static std::map<std::filesystem::path, Known> known;
  std::error_code no_time, no_size;
  const auto written = std::filesystem::last_write_time(path, no_time);
  const std::uintmax_t size = std::filesystem::file_size(path, no_size);
  if (no_time || no_size) return read_contents(path);
  const std::filesystem::path name = std::filesystem::absolute(path);
  {
    const std::lock_guard lock(mutex);
    const auto found = known.find(name);
    if (found != known.end() && found->second.written == written && found->second.size == size)
      return found->second.contents;
  }
  Contents out = read_contents(path);
  const std::lock_guard lock(mutex);
  known.insert_or_assign(name, Known{written, size, out});
  return out;
}

}  // namespace flexura::superelement
