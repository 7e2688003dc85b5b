// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/hdf5/library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <new>
#include <type_traits>

namespace flexura::hdf5 {
namespace {

static_assert(std::is_same_v<hid_t, std::int64_t>);

herr_t collect(unsigned, const H5E_error2_t* entry, void* out) {
  auto& lines = *static_cast<std::vector<std::string>*>(out);
  if (entry->desc) lines.emplace_back(entry->desc);
  return 0;
}

}  // namespace

void silence() {
  // At the program's end the library would close what is open, and a file whose disk is full is still half
  // open then: it fails in that (HDF5 1.10.8, H5F__close_cb).  Files of ours are closed where their end is.
  [[maybe_unused]] static const herr_t once = H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::string reason() {
  std::vector<std::string> lines;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, collect, &lines);
  H5Eclear2(H5E_DEFAULT);
  const auto says = [&](const char* words) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(words) != std::string::npos; });
  };
  if (says("checksum") || says("Fletcher32"))
    return "its checksum does not match, the file is damaged; make it again";
  if (says("truncated file")) return "the file is cut short; make it again";
  if (says("signature not found")) return "is not an HDF5 file";
  if (says("already open for")) return writing_mark;
  if (says("unable to lock file"))
    return "another program has it open for writing; wait until it has finished";
  if (says("memory allocation failed") || says("unable to allocate") || says("can't allocate"))
    return no_memory;
  for (const std::string& line : lines) {  // the operating system's own words
    const std::string key = "error message = '";
    if (const auto at = line.find(key); at != std::string::npos) {
      const auto start = at + key.size();
      return line.substr(start, line.find('\'', start) - start);
    }
  }
  return "the file is damaged; make it again";
}

[[noreturn]] void fail(const std::string& label) {
  const std::string why = reason();
  // Nothing is wrong with the input then.
  if (why == no_memory) throw std::bad_alloc();
  if (why == "No space left on device" || why == "Disk quota exceeded")
    throw std::runtime_error(label + ": " + why + "; make room or choose another folder");
  throw BadFile(label + ": " + why);
}

void check(herr_t status, const std::string& label) {
  if (status < 0) fail(label);
}

Handle owned(hid_t id, Handle::Closer closer, const std::string& label) {
  if (id < 0) fail(label);
  return Handle(id, closer);
}

std::string child(const std::string& label, const std::string& name) {
  return label.ends_with('/') ? label + name : label + "/" + name;
}

Shape shape_of(hid_t dataset, const std::string& label) {
  const Handle space = owned(H5Dget_space(dataset), H5Sclose, label);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0 || rank > 8) fail(label);
  std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
  if (rank > 0) check(H5Sget_simple_extent_dims(space.get(), extent.data(), nullptr), label);
  return Shape(extent.begin(), extent.end());
}

namespace {
constexpr double kMostPacked = 1100.0;  // deflate: 1,032
constexpr double kFree = 256.0 * (1 << 20);

[[noreturn]] void refuse_size(const std::string& label, double bytes, double stored) {
  throw BadFile(fmt::format(
      "{}: stands for {:.3g} MB, of which the file holds {:.3g} MB; it is damaged or made to fill the memory",
      label, 1e-6 * bytes, 1e-6 * stored));
}
}  // namespace

void require_stored(hid_t dataset, const std::string& label) {
  double bytes = 1.0;
  for (const std::size_t n : shape_of(dataset, label)) bytes *= static_cast<double>(n);
  const Handle type = owned(H5Dget_type(dataset), H5Tclose, label);
  bytes *= static_cast<double>(H5Tget_size(type.get()));
  // A writer at work may have made room for rows that are not there yet.
  constexpr double kUnderWay = 16.0 * (1 << 20);
  const double stored = static_cast<double>(H5Dget_storage_size(dataset));
  if (bytes > kUnderWay + kMostPacked * stored) refuse_size(label, bytes, stored);
}

void count_read(hid_t dataset, double bytes, const std::string& label) {
  static std::mutex mutex;
  static std::map<unsigned long, double> read;  // by HDF5's number of the open file
  H5O_info_t info;
  check(H5Oget_info2(dataset, &info, H5O_INFO_BASIC), label);
  const Handle file = owned(H5Iget_file_id(dataset), H5Fclose, label);
  hsize_t size = 0;
  check(H5Fget_filesize(file.get(), &size), label);
  const std::lock_guard lock(mutex);
  double& sum = read[info.fileno];
  sum += bytes;
  if (sum > kFree + kMostPacked * static_cast<double>(size))
    refuse_size(label, sum, static_cast<double>(size));
}

const std::string& checked_name(const std::string& name, const std::string& label) {
  if (name.empty() || name == "." || name.find('/') != std::string::npos) {
    throw BadFile(label + ": \"" + name + "\" cannot be a name in an HDF5 file; use a name without \"/\"");
  }
  return name;
}

}  // namespace flexura::hdf5
