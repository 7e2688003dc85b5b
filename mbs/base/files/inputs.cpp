// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/inputs.hpp"

#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/vfs.h>

#include <map>
#include <mutex>
#include <set>
#include <stdexcept>

#include "mbs/base/files/claimed.hpp"

namespace flexura::files {
namespace {

namespace fs = std::filesystem;

struct Process {
  std::recursive_mutex guard;  // a claim that ends asks what has been read
  bool notes = false;
  std::map<Identity, fs::path> inputs;
  std::set<Identity> own;
  std::map<fs::path, std::weak_ptr<Claimed>> claims;
};

Process& process() {
  static Process the_one;
  return the_one;
}

[[noreturn]] void refuse(const fs::path& output, const fs::path& input) {
  const std::string also = output == input ? "" : fmt::format(", as {},", input.string());
  throw std::invalid_argument(fmt::format(
      "{}: is read by this command{} and would be overwritten; name another output", output.string(), also));
}

std::optional<fs::path> find(Process& p, const fs::path& file) {
  const auto id = identity_of(file);
  const auto found = id ? p.inputs.find(*id) : p.inputs.end();
  if (found == p.inputs.end()) return std::nullopt;
  return found->second;
}

}  // namespace

void guard_inputs() {
  Process& p = process();
  const std::scoped_lock lock(p.guard);
  p.notes = true;
  p.inputs.clear();
}

void require_no_device(const fs::path& file) {
  std::error_code none;
  const fs::file_status status = fs::status(file, none);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
    throw std::invalid_argument(
        fmt::format("{}: is a device or a pipe, a file is wanted; write what comes from it into a file first",
                    file.string()));
  struct stat info {};
  struct statfs system {};
  if (!fs::is_regular_file(status) || ::stat(file.c_str(), &info) != 0) return;
  // Files of the kernel may wait for ever and have no end.
  if (::statfs(file.c_str(), &system) == 0 &&
      (system.f_type == PROC_SUPER_MAGIC || system.f_type == SYSFS_MAGIC))
    throw std::invalid_argument(fmt::format(
        "{}: is a file of the kernel, one on a disk is wanted; copy what it says into a file first",
        file.string()));
  // Of what is read by and by only its own end would stop it.
  constexpr double kLarge = 1e9, kHoles = 1000.0, kBlock = 512.0;
  const auto size = static_cast<double>(info.st_size);
  if (size > kLarge && size > kHoles * kBlock * static_cast<double>(info.st_blocks))
    throw std::invalid_argument(fmt::format(
        "{}: is {:.3g} GB long, of which the disk holds {:.3g} MB; it is damaged or made to fill the memory; "
        "copy it anew from where it came",
        file.string(), 1e-9 * size, 1e-6 * kBlock * static_cast<double>(info.st_blocks)));
}

void note_input(const fs::path& file) {
  require_no_device(file);
  Process& p = process();
  const std::scoped_lock lock(p.guard);
  const auto id = p.notes ? identity_of(file) : std::nullopt;
  if (!id || p.own.contains(*id)) return;
  for (const auto& [place, held] : p.claims) {
    const std::shared_ptr<Claimed> claimed = held.lock();
    if (claimed && identity_of(place) == id) refuse(claimed->output, file);
  }
  p.inputs.try_emplace(*id, file);
}

std::optional<fs::path> input_like(const fs::path& file) {
  Process& p = process();
  const std::scoped_lock lock(p.guard);
  return find(p, file);
}

void refuse_input(const fs::path& output, const fs::path& place) {
  if (const auto input = input_like(place)) refuse(output, *input);
}

void note_own(const fs::path& file) {
  Process& p = process();
  const std::scoped_lock lock(p.guard);
  if (const auto id = p.notes ? identity_of(file) : std::nullopt) p.own.insert(*id);
}

std::shared_ptr<Claimed> claim(const fs::path& output) {
  const fs::path place = place_of(output);
  refuse_input(output, place);
  Process& p = process();
  const std::scoped_lock lock(p.guard);
  std::erase_if(p.claims, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<Claimed>& held = p.claims[place];
  std::shared_ptr<Claimed> claimed = held.lock();
  if (!claimed) held = claimed = std::make_shared<Claimed>(output, place);
  return claimed;
}

}  // namespace flexura::files
