// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "mbs/base/files/lock.hpp"
#include "mbs/base/files/signals.hpp"

/// The one way in which files are written: claimed before anything is computed, written under a private name
/// in the same folder, renamed when whole, removed in every other case.
namespace flexura::files {

struct Claimed;

/// Outputs that a command is going to write.  Each is checked at once: a place where a file can be, not
/// read-only, not an input (whatever links lead to it), not written by another process, room on the disk.
class Claims {
 public:
  /// An empty path is no output.  Throws std::invalid_argument for what the user can mend by another name,
  /// std::runtime_error for a full disk: one sentence.
  Claims& add(const std::filesystem::path& output);

 private:
  std::vector<std::shared_ptr<Claimed>> held_;
};

/// Throws std::runtime_error where less room than `bytes` is left for this output.
void expect_size(const std::filesystem::path& output, double bytes);

/// An empty file of a private name beside an output, FILE.part or FILE.PROCESS.part; removed with this object
/// unless it has been given its name.
class PrivateFile {
 public:
  /// Throws std::system_error.
  explicit PrivateFile(Claimed& claimed);
  ~PrivateFile();
  PrivateFile(const PrivateFile&) = delete;
  PrivateFile& operator=(const PrivateFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// 0, or what went wrong.
  int rename(const std::filesystem::path& to);
  void remove() noexcept;

 private:
  std::filesystem::path path_;
  std::optional<Unfinished> unfinished_;
};

/// One file on its way.  Claims it, unless the command has.
class Output {
 public:
  explicit Output(const std::filesystem::path& path);
  ~Output();  ///< removes the private file unless it was committed
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  /// The private file, empty at first.
  const std::filesystem::path& part() const { return part_->path(); }
  /// Changes the private file, closed by now, so that it is whole at any moment, whatever kills the process:
  /// `change` works on a copy, which takes the file's place when it returns and is removed when it throws.
  /// Where a copy cannot be made (no room) it works on the file itself.
  void change(const std::function<void(const std::filesystem::path&)>& change);
  /// The file is whole and closed: brings it to the disk and gives it its name.  Throws std::runtime_error.
  void commit();

 private:
  [[noreturn]] void fail(int why) const;

  std::filesystem::path path_;
  std::shared_ptr<Claimed> claimed_;
  std::optional<PrivateFile> part_;
};

/// The whole content or nothing.  Throws std::runtime_error that names the file and the reason.
void write_whole(const std::filesystem::path& path, std::string_view content);

}  // namespace flexura::files
