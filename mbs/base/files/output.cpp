// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/output.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>

#include "mbs/base/files/claimed.hpp"
#include "mbs/base/files/inputs.hpp"

namespace flexura::files {
namespace {

namespace fs = std::filesystem;

/// Brings a file to the disk; 0, or what went wrong.
int synchronise(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  const int why = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  return why == EINVAL || why == EROFS || why == ENOTSUP ? 0 : why;  // a file system that cannot
}

/// Makes an empty file of a name that was free.
fs::path make_part(const fs::path& place, int& why) {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    fs::path part = place;
    if (attempt > 0) part += fmt::format(".{}", ::getpid());
    if (attempt > 1) part += fmt::format("-{}", attempt);
    part += ".part";
    const int descriptor = ::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (descriptor >= 0) {
      // A file that is replaced hands down who may read it.
      struct stat before {};
      if (::stat(place.c_str(), &before) == 0) ::fchmod(descriptor, before.st_mode & 0777);
      ::close(descriptor);
      return part;
    }
    if ((why = errno) != EEXIST) return {};
  }
  return {};
}

}  // namespace

Claims& Claims::add(const fs::path& output) {
  if (output.empty()) return *this;
  std::shared_ptr<Claimed> claimed = claim(output);
  if (claimed->by_command)
    throw std::invalid_argument(
        fmt::format("{} and {} are one file, and two things are to be written there; name two",
                    claimed->output.string(), output.string()));
  claimed->by_command = true;
  held_.push_back(std::move(claimed));
  return *this;
}

void expect_size(const fs::path& output, double bytes) {
  const fs::path place = place_of(output);
  require_room(output, place.parent_path(), bytes);
}

PrivateFile::PrivateFile(Claimed& claimed) {
  int why = 0;
  const HeldBack until_it_is_known;
  path_ = make_part(claimed.place, why);
  if (path_.empty()) throw std::system_error(why, std::generic_category());
  try {
    if ((why = claimed.lock.note(path_)) != 0) throw std::system_error(why, std::generic_category());
    unfinished_.emplace(path_);
  } catch (...) {  // memory, disk: nobody else knows of the file yet
    ::unlink(path_.c_str());
    throw;
  }
}

PrivateFile::~PrivateFile() {
  remove();
}

void PrivateFile::remove() noexcept {
  if (unfinished_) ::unlink(path_.c_str());
  unfinished_.reset();
}

int PrivateFile::rename(const fs::path& to) {
  if (::rename(path_.c_str(), to.c_str()) != 0) return errno;
  unfinished_.reset();
  return 0;
}

Output::Output(const fs::path& path) : path_(path), claimed_(claim(path)) {
  claimed_->lock.remove_left();
  try {
    part_.emplace(*claimed_);
  } catch (const std::system_error& e) {
    fail(e.code().value());
  }
}

Output::~Output() = default;

void Output::fail(int why) const {
  throw std::runtime_error(
      fmt::format("{}: cannot be written{}{}; check the folder, its permissions and the disk", path_.string(),
                  why ? ": " : "", why ? std::strerror(why) : ""));
}

void Output::change(const std::function<void(const fs::path&)>& change) {
  std::optional<PrivateFile> copy;
  try {
    copy.emplace(*claimed_);
    fs::copy_file(part(), copy->path(), fs::copy_options::overwrite_existing);
  } catch (const std::system_error&) {  // no room for a copy
    copy.reset();
    return change(part());
  }
  change(copy->path());
  if (const int why = copy->rename(part()); why != 0) fail(why);
}

void Output::commit() {
  refuse_input(path_, claimed_->place);
  int why = synchronise(part());
  if (why == 0) why = part_->rename(claimed_->place);
  if (why != 0) {
    part_->remove();
    fail(why);
  }
  // Where the power fails before the folder is on the disk, the name still leads to the old file: whole, too.
  note_own(claimed_->place);
}

void write_whole(const fs::path& path, std::string_view content) {
  Output output(path);
  const int descriptor = ::open(output.part().c_str(), O_WRONLY | O_CLOEXEC);
  int why = descriptor < 0 ? errno : 0;
  for (std::size_t done = 0; why == 0 && done < content.size();) {
    const ssize_t n = ::write(descriptor, content.data() + done, content.size() - done);
    if (n > 0)
      done += static_cast<std::size_t>(n);
    else if (n == 0 || errno != EINTR)
      why = n == 0 ? ENOSPC : errno;
  }
  if (descriptor >= 0 && ::close(descriptor) != 0 && why == 0) why = errno;
  if (why != 0)
    throw std::runtime_error(
        fmt::format("{}: cannot be written: {}; check the folder, its permissions and the disk",
                    path.string(), std::strerror(why)));
  output.commit();
}

}  // namespace flexura::files
