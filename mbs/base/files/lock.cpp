// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/left_behind.hpp"

namespace flexura::files {
namespace {

namespace fs = std::filesystem;

std::string host() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 ? name : "";
}

[[noreturn]] void refuse(const fs::path& output, const fs::path& folder, int why) {
  const std::string where = fmt::format("{}: cannot be written: ", output.string());
  switch (why) {
    case EROFS:
      throw std::invalid_argument(
          where +
          fmt::format("{} is on a read-only file system; name an output in another folder", folder.string()));
    case EACCES:
    case EPERM:
      throw std::invalid_argument(
          where + fmt::format("the folder {} takes no files from you ({}); name an output in another folder",
                              folder.string(), std::strerror(why)));
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      throw std::runtime_error(
          where + fmt::format("no room is left in {} ({}); free some or name an output on another disk",
                              folder.string(), std::strerror(why)));
    case ENAMETOOLONG:
      throw std::invalid_argument(where + "its name is too long; name another output");
    case EIO:
    case EMFILE:
    case ENFILE:
    case ENOMEM:
      throw std::runtime_error(where + fmt::format("{} in {}; mend that or name an output in another folder",
                                                   std::strerror(why), folder.string()));
    default:  // a folder of a kind that takes no files: /proc, ...
      throw std::invalid_argument(where + fmt::format("{} in {}; name an output in another folder",
                                                      std::strerror(why), folder.string()));
  }
}

/// "1234 machine", by the process that holds the lock.
std::string holder(int descriptor) {
  // It may be between taking the lock and writing who it is.
  for (int attempt = 0; attempt < 50; ++attempt) {
    char text[300] = {};
    if (::pread(descriptor, text, sizeof text - 1, 0) > 0) {
      const std::string whole = text, pid = whole.substr(0, whole.find_first_of(" \n"));
      const std::size_t blank = whole.find(' ');
      const std::string machine =
          blank == std::string::npos ? "" : whole.substr(blank + 1, whole.find('\n') - blank - 1);
      return fmt::format("process {}{}", pid, machine == host() ? "" : " on " + machine);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return "another process";
}

/// The private files that a holder has noted, and empty ones: it may have ended between the two.
std::vector<fs::path> left_by(int descriptor, const fs::path& place) {
  std::string text(std::size_t{1} << 16, '\0');
  const ssize_t n = ::pread(descriptor, text.data(), text.size(), 0);
  text.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  if (text.empty()) return {};
  std::vector<fs::path> left = private_files(place, "");
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);  // who it was
  while (std::getline(lines, line))
    if (is_private_name(line, place.filename().string())) left.push_back(place.parent_path() / line);
  return left;
}

bool is_still(const fs::path& file, int descriptor) {
  struct stat by_name {
  }, by_descriptor{};
  return ::fstat(descriptor, &by_descriptor) == 0 && ::stat(file.c_str(), &by_name) == 0 &&
         by_name.st_dev == by_descriptor.st_dev && by_name.st_ino == by_descriptor.st_ino;
}

}  // namespace

Lock::Lock(const fs::path& place, const fs::path& output)
    : file_(place.parent_path() / fmt::format(".{}.lock", place.filename().string())) {
  const HeldBack until_it_is_known;
  bool is_held = false;
  for (;;) {
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (descriptor_ < 0) refuse(output, place.parent_path(), errno);
    is_held = ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
    if (!is_held && errno == EWOULDBLOCK) {
      const std::string who = holder(descriptor_);
      ::close(descriptor_);
      throw Busy(fmt::format("{}: is being written by {}; wait until it has ended, or name another output",
                             output.string(), who));
    }  // a file system without locks: nothing better is to be had
    if (is_still(file_, descriptor_)) break;
    ::close(descriptor_);  // its holder has just ended and taken the name away
  }
  int why = 0;
  try {
    if (is_held) left_ = left_by(descriptor_, place);
    if (left_.empty()) unfinished_.emplace(file_);
    std::string text = fmt::format("{} {}\n", ::getpid(), host());
    for (const fs::path& part : left_) text += part.filename().string() + '\n';
    errno = 0;
    if (::ftruncate(descriptor_, 0) != 0 ||
        ::pwrite(descriptor_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()))
      why = errno ? errno : ENOSPC;
  } catch (...) {  // memory
    ::unlink(file_.c_str());
    ::close(descriptor_);
    throw;
  }
  if (why != 0) {
    ::unlink(file_.c_str());
    ::close(descriptor_);
    refuse(output, place.parent_path(), why);
  }
}

int Lock::note(const fs::path& part) {
  std::string line = part.filename().string() + '\n';
  if (line == noted_) return 0;
  const off_t end = ::lseek(descriptor_, 0, SEEK_END);
  errno = 0;
  if (end >= 0 && ::pwrite(descriptor_, line.data(), line.size(), end) == static_cast<ssize_t>(line.size())) {
    noted_ = std::move(line);
    return 0;
  }
  return errno ? errno : ENOSPC;
}

void Lock::unlink_left() noexcept {
  try {
    for (const fs::path& part : left_)
      if (!input_like(part)) ::unlink(part.c_str());
  } catch (const std::exception&) {  // memory: they stay
  }
  left_.clear();
}

void Lock::remove_left() {
  unlink_left();
  if (!unfinished_) unfinished_.emplace(file_);
}

Lock::~Lock() {
  unlink_left();
  ::unlink(file_.c_str());  // while it is locked: who opens it after that finds another name
  ::close(descriptor_);
}

}  // namespace flexura::files
