// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/factor_store.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

namespace flexura::linalg {
namespace {

constexpr double kGigabyte = 1e9;

double number_in(const char* file) {
  std::ifstream in(file);
  double value = 0.0;
  return in >> value ? value : std::numeric_limits<double>::infinity();  // "max" is no number: no limit
}

// A file of n bytes without a name, its room on the disk reserved.
int nameless_file(std::size_t n, const std::filesystem::path& folder) {
  std::string name = (folder / "flexura-factor-XXXXXX").string();
  const int file = mkostemp(name.data(), O_CLOEXEC);
  if (file < 0)
    throw std::runtime_error(
        fmt::format("the factor needs a temporary file, which cannot be made in {} ({}): set TMPDIR to a "
                    "folder on a disk",
                    folder.string(), std::strerror(errno)));
  unlink(name.c_str());
  if (const int error = posix_fallocate(file, 0, static_cast<off_t>(n)); error != 0) {
    close(file);
    std::error_code none;
    const auto room = std::filesystem::space(folder, none);
    throw std::runtime_error(
        fmt::format("the factor ({:.1f} GB) does not fit onto the disk of {} ({:.1f} GB are free; {}; of "
                    "memory {:.1f} GB are free): use a coarser mesh, a machine with more memory, or set "
                    "TMPDIR to a folder on a larger disk",
                    static_cast<double>(n) / kGigabyte, folder.string(),
                    none ? 0.0 : static_cast<double>(room.available) / kGigabyte, std::strerror(error),
                    available_memory() / kGigabyte));
  }
  return file;
}

// TMPDIR; the standard library's own throws without a name where that is no folder.
std::filesystem::path temporary_folder() {
  const char* const given = std::getenv("TMPDIR");
  return given && *given ? given : "/tmp";
}

char* map(std::size_t n, int flags, int file) {
  void* data = mmap(nullptr, n, PROT_READ | PROT_WRITE, flags, file, 0);
  if (data == MAP_FAILED)
    throw std::runtime_error(fmt::format(
        "memory does not suffice for the factor ({:.1f} GB; {:.1f} GB are free): use a coarser mesh "
        "or a machine with more memory",
        static_cast<double>(n) / kGigabyte, available_memory() / kGigabyte));
  return static_cast<char*>(data);
}

}  // namespace

double available_memory() {
  double available = std::numeric_limits<double>::infinity();
  std::ifstream info("/proc/meminfo");
  for (std::string word; info >> word;)
    if (word == "MemAvailable:" && info >> available) {
      available *= 1024.0;
      break;
    }
  const double limit = number_in("/sys/fs/cgroup/memory.max");
  if (limit < std::numeric_limits<double>::infinity())
    available = std::min(available, limit - number_in("/sys/fs/cgroup/memory.current"));
  return available;
}

FactorStore FactorStore::in_memory(std::size_t n_bytes) {
  FactorStore store;
  store.n_ = n_bytes;
  if (n_bytes == 0) return store;
  store.data_ = map(n_bytes, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1);
  madvise(store.data_, n_bytes, MADV_HUGEPAGE);  // fewer page faults; no matter where there are none
  return store;
}

FactorStore FactorStore::in_file(std::size_t n_bytes, const std::filesystem::path& folder) {
  FactorStore store;
  store.n_ = n_bytes;
  store.is_file_ = true;
  if (n_bytes == 0) return store;
  const int file = nameless_file(n_bytes, folder.empty() ? temporary_folder() : folder);
  try {
    store.data_ = map(n_bytes, MAP_SHARED, file);
  } catch (...) {
    close(file);
    throw;
  }
  close(file);  // the mapping keeps it
  return store;
}

FactorStore::~FactorStore() {
  if (data_) munmap(data_, n_);
}

void FactorStore::will_need(std::size_t first, std::size_t count) const {
  if (!is_file_ || count == 0) return;
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const std::uintptr_t begin = reinterpret_cast<std::uintptr_t>(data_ + first) / page * page;
  madvise(reinterpret_cast<void*>(begin), reinterpret_cast<std::uintptr_t>(data_ + first + count) - begin,
          MADV_WILLNEED);
}

}  // namespace flexura::linalg
