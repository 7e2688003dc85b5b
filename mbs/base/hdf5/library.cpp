// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/hdf5/library.hpp"

#include <fmt/format.h>
#include <zlib.h>

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

namespace {

// What a deflated stream stands for [bytes], counted no further than `most`.
double inflated_size(const std::vector<unsigned char>& packed, double most) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  std::vector<unsigned char> out(1 << 16);
  stream.next_in = const_cast<unsigned char*>(packed.data());
  stream.avail_in = static_cast<unsigned>(packed.size());
  int status = Z_OK;
  double bytes = 0.0;
  while (status == Z_OK && bytes <= most) {
    stream.next_out = out.data();
    stream.avail_out = static_cast<unsigned>(out.size());
    status = inflate(&stream, Z_NO_FLUSH);  // what is damaged HDF5 tells
    bytes += static_cast<double>(out.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  return bytes;
}

// HDF5 unpacks a chunk to the end of its stream, however long the chunk is.
void require_bounded_chunks(hid_t dataset, const Shape& shape, double type_size, const std::string& label) {
  const Handle properties = owned(H5Dget_create_plist(dataset), H5Pclose, label);
  if (shape.empty() || H5Pget_layout(properties.get()) != H5D_CHUNKED) return;
  int n_deflates = 0;
  for (int k = 0; k < H5Pget_nfilters(properties.get()); ++k) {
    unsigned flags = 0, configuration = 0;
    std::size_t n_values = 0;
    n_deflates += H5Pget_filter2(properties.get(), static_cast<unsigned>(k), &flags, &n_values, nullptr, 0,
                                 nullptr, &configuration) == H5Z_FILTER_DEFLATE;
  }
  if (n_deflates == 0) return;
  if (n_deflates > 1)
    throw BadFile(label + ": is packed more than once; it is damaged or made to fill the memory");
  std::vector<hsize_t> chunk(shape.size()), at(shape.size(), 0);
  check(H5Pget_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data()), label);
  double bytes = type_size;
  for (const hsize_t n : chunk) bytes *= static_cast<double>(n);
  constexpr double kHarmless = 1 << 30;
  for (bool more = true; more;) {
    unsigned mask = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t stored = 0;
    check(H5Dget_chunk_info_by_coord(dataset, at.data(), &mask, &address, &stored), label);
    // Streams of deflate are longer than what they stand for by 5 bytes in 16,384 at most.
    const double size = static_cast<double>(stored);
    if (address != HADDR_UNDEF && size > 1.01 * bytes + 1024.0) refuse_size(label, kMostPacked * size, size);
    if (address != HADDR_UNDEF && kMostPacked * size > kHarmless) {
      std::vector<unsigned char> packed(stored);
      std::uint32_t used = 0;
      check(H5Dread_chunk(dataset, H5P_DEFAULT, at.data(), &used, packed.data()), label);
      if (const double is = inflated_size(packed, bytes + 1024.0); is > bytes + 1024.0)
        refuse_size(label, is, size);
    }
    more = false;
    for (std::size_t i = shape.size(); i-- > 0 && !more;) {
      at[i] += chunk[i];
      more = at[i] < shape[i];
      if (!more) at[i] = 0;
    }
  }
}

}  // namespace

void require_stored(hid_t dataset, const std::string& label) {
  double bytes = 1.0;
  const Shape shape = shape_of(dataset, label);
  for (const std::size_t n : shape) bytes *= static_cast<double>(n);
  const Handle type = owned(H5Dget_type(dataset), H5Tclose, label);
  const auto type_size = static_cast<double>(H5Tget_size(type.get()));
  bytes *= type_size;
  // A writer at work may have made room for rows that are not there yet.
  constexpr double kUnderWay = 16.0 * (1 << 20);
  const double stored = static_cast<double>(H5Dget_storage_size(dataset));
  if (bytes > kUnderWay + kMostPacked * stored) refuse_size(label, bytes, stored);
  require_bounded_chunks(dataset, shape, type_size, label);
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
