// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/library_file.hpp"

#include <dlfcn.h>
#include <elf.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <link.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <tuple>
#include <vector>

namespace flexura::mbs {
namespace {

using Header = ElfW(Ehdr);
using Segment = ElfW(Phdr);

/// Of this program itself: what a library must be made for.
Header own_header() {
  Header header{};
  std::ifstream("/proc/self/exe", std::ios::binary).read(reinterpret_cast<char*>(&header), sizeof header);
  return header;
}

std::string wrong_in_header(std::ifstream& file, std::uint64_t size) {
  Header header{};
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header) ||
      std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0)
    return "is no shared library";
  const Header own = own_header();
  if (header.e_ident[EI_CLASS] != own.e_ident[EI_CLASS] || header.e_ident[EI_DATA] != own.e_ident[EI_DATA] ||
      header.e_machine != own.e_machine)
    return "is made for another kind of processor";
  if (header.e_type != ET_DYN) return "is no shared library (compile with -shared)";
  const auto ends_within = [size](std::uint64_t start, std::uint64_t length) {
    return start <= size && length <= size - start;
  };
  if (header.e_phentsize != sizeof(Segment) ||
      !ends_within(header.e_phoff, std::uint64_t{header.e_phnum} * sizeof(Segment)))
    return "is cut short or damaged";
  std::vector<Segment> segments(header.e_phnum);
  file.seekg(static_cast<std::streamoff>(header.e_phoff));
  file.read(reinterpret_cast<char*>(segments.data()),
            static_cast<std::streamsize>(segments.size() * sizeof(Segment)));
  bool loads = false;
  for (const Segment& segment : segments) {
    if (!ends_within(segment.p_offset, segment.p_filesz)) return "is cut short or damaged";
    loads = loads || segment.p_type == PT_LOAD;
  }
  return loads ? "" : "is cut short or damaged";
}

constexpr int survived = 42;  // no library ends its process with that by chance
constexpr unsigned patience_s = 20;

/// What becomes of a process that loads it.
std::string wrong_when_loaded(const std::filesystem::path& path) {
  const std::string name = std::filesystem::absolute(path).string();
  const pid_t child = fork();
  if (child < 0) return "";  // no process to spare: nothing is known
  if (child == 0) {
    alarm(patience_s);
    if (const int nowhere = open("/dev/null", O_RDWR); nowhere >= 0)
      for (int fd = 0; fd < 3; ++fd) dup2(nowhere, fd);
    dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);  // an orderly refusal is told by the one that counts
    _exit(survived);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == survived) return "";
  if (WIFEXITED(status)) return "ends the program when it is loaded";
  return fmt::format("makes the program fail when it is loaded ({})", strsignal(WTERMSIG(status)));
}

}  // namespace

std::string why_not_loadable(const std::filesystem::path& library) {
  struct stat info {};
  if (stat(library.c_str(), &info) != 0) return std::string("cannot be read: ") + std::strerror(errno);
  if (!S_ISREG(info.st_mode)) return "is no file";
  std::ifstream file(library, std::ios::binary);
  if (!file) return "cannot be read; check its permissions";
  if (const std::string why = wrong_in_header(file, static_cast<std::uint64_t>(info.st_size)); !why.empty())
    return why;
  static std::mutex one;
  static std::map<std::tuple<dev_t, ino_t, off_t, time_t, long>, std::string> tried;
  const std::lock_guard lock(one);
  const auto [entry, is_new] =
      tried.try_emplace({info.st_dev, info.st_ino, info.st_size, info.st_mtim.tv_sec, info.st_mtim.tv_nsec});
  if (is_new) entry->second = wrong_when_loaded(library);
  return entry->second;
}

}  // namespace flexura::mbs
