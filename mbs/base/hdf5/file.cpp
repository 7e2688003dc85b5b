// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/hdf5/file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <fstream>

#include "mbs/base/files/inputs.hpp"
#include "mbs/base/hdf5/library.hpp"

namespace flexura::hdf5 {
namespace {

// A writer killed between its runs, while it set up the next, leaves the mark of exclusive writing, which
// HDF5 refuses for good.  What it had written is there (changes stay in memory until the file is closed), so
// the mark is lifted, as HDF5's own tool h5clear does, in a copy in memory: the file itself stays untouched.
hid_t open_copy_without_mark(const std::filesystem::path& path) {
  H5Eclear2(H5E_DEFAULT);
  std::ifstream in(path, std::ios::binary);
  std::string image((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const Handle access = owned(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, path.string());
  const hbool_t clear = true;
  if (H5Pset_fapl_core(access.get(), std::size_t{1} << 20, false) < 0 ||
      H5Pset_file_image(access.get(), image.data(), image.size()) < 0 ||
      H5Pset(access.get(), "clear_status_flags", &clear) < 0) {
    return -1;
  }
  return H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get());
}

// A file that cannot be written can never be closed, and HDF5 falls over it when the program ends.  What it has
// still to write goes nowhere instead; the file is given up.
void write_into_nothing(hid_t file) {
  void* driver = nullptr;
  if (H5Fget_vfd_handle(file, H5P_DEFAULT, &driver) < 0 || driver == nullptr) return;
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nothing < 0) return;
  ::dup2(nothing, *static_cast<const int*>(driver));
  ::close(nothing);
}

}  // namespace

void start() {
  silence();
}

File::File(const std::filesystem::path& path, Mode mode) : path_(path) {
  silence();
  const std::string label = path.string();
  std::error_code ignored;
  if (mode != Mode::create) {
    if (!std::filesystem::exists(path, ignored))
      throw BadFile(label + ": there is no such file; check the path");
    if (std::filesystem::is_directory(path, ignored))
      throw BadFile(label + ": is a folder, a file is wanted");
    if (mode == Mode::read) files::note_input(path);
  } else if (path.has_parent_path() && !std::filesystem::is_directory(path.parent_path(), ignored)) {
    throw BadFile(label + ": the folder " + path.parent_path().string() + " does not exist; make it first");
  }
  const Handle access = owned(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, label);
  check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_V110), label);
  check(H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG), label);
  // A reader takes no lock: it must not keep a running simulation from its own file.
  check(H5Pset_file_locking(access.get(), mode != Mode::read, true), label);
  hid_t id = -1;
  switch (mode) {
    case Mode::create: {
      const Handle root = owned(H5Pcreate(H5P_FILE_CREATE), H5Pclose, label);
      check(H5Pset_obj_track_times(root.get(), false), label);  // equal content gives equal bytes
      id = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, root.get(), access.get());
      if (id < 0) throw Error(label + ": cannot be written; check the folder, its permissions and the disk");
      break;
    }
    case Mode::modify:
      id = H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get());
      break;
    case Mode::append:
      id = H5Fopen(path.c_str(), H5F_ACC_RDWR | H5F_ACC_SWMR_WRITE, access.get());
      break;
    case Mode::read:
      id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get());
      if (id < 0) {
        const std::string why = reason();
        if (why != writing_mark) throw BadFile(label + ": " + why);
        // A writer that appends, or one that was killed while it did, has left its mark in the file. What is
        // there is consistent; HDF5 wants to be told that we know. It then reads a block whose checksum fails
        // again, in case it was just being written, and waits twice as long each time: 20 attempts are a
        // millisecond, its own 100 eternal.
        check(H5Pset_metadata_read_attempts(access.get(), 20), label);
        id = H5Fopen(path.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, access.get());
        if (id < 0) id = open_copy_without_mark(path);
      }
      break;
  }
  handle_ = owned(id, H5Fclose, label);
}

Group File::root() const {
  const std::string label = path_.string() + ": /";
  return Group(owned(H5Gopen2(handle_.get(), "/", H5P_DEFAULT), H5Gclose, label), label);
}

void File::flush() {
  writing([&] { check(H5Fflush(handle_.get(), H5F_SCOPE_LOCAL), path_.string()); });
}

void File::close() {
  writing([&] {
    if (!handle_.is_open()) return;
    const herr_t flushed = H5Fflush(handle_.get(), H5F_SCOPE_LOCAL);
    const std::string why = flushed < 0 ? reason() : "";
    if (flushed < 0) write_into_nothing(handle_.get());
    const int closed = handle_.close();
    if (flushed < 0) throw BadFile(path_.string() + ": " + why);
    check(closed, path_.string());
  });
}

}  // namespace flexura::hdf5
