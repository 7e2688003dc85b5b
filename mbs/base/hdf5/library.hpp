// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <hdf5.h>

#include "mbs/base/hdf5/file.hpp"

/// The C library as this folder's own files use it: every return value checked, every failure one sentence.
/// Nobody else includes this header.
namespace flexura::hdf5 {

/// What read-only opening says of a file that carries the mark of exclusive writing.
inline constexpr const char* writing_mark =
    "another program is writing it, or was killed while it set the file up; wait or make it again";

/// What reason() says where memory is short; fail() makes a std::bad_alloc of it.
inline constexpr const char* no_memory = "there is not enough memory";

/// HDF5 prints a stack of a dozen lines; we keep it quiet and make one sentence of it.
void silence();

/// The reason for HDF5's last failure in one sentence; takes it off HDF5's stack.
std::string reason();

/// Throws BadFile "LABEL: reason".
[[noreturn]] void fail(const std::string& label);

/// Throws like fail when `status` is negative.
void check(herr_t status, const std::string& label);

/// Takes over `id`, or fails when it is negative.
Handle owned(hid_t id, Handle::Closer closer, const std::string& label);

/// The label of `name` inside of what is labelled `label`.
std::string child(const std::string& label, const std::string& name);

Shape shape_of(hid_t dataset, const std::string& label);

/// Refuses a dataset that claims more than its file can hold: deflate packs 1,032 to 1 at most, and what our writers write is
/// stored whole.  BadFile before anything is allocated.
void require_stored(hid_t dataset, const std::string& label);

/// Counts `bytes` that are to be read of the dataset's file, the same ones each time: BadFile where they are more than the file can
/// stand for (links make many datasets of one).
void count_read(hid_t dataset, double bytes, const std::string& label);

/// `name` again, when it can stand in an HDF5 file; BadFile otherwise.
const std::string& checked_name(const std::string& name, const std::string& label);

/// Runs `work`; while writing, the disk or the folder is to blame, not the input: BadFile becomes Error.
template <typename Work>
auto writing(Work&& work) {
  try {
    return work();
  } catch (const BadFile& failure) {
    throw Error(failure.what());
  }
}

}  // namespace flexura::hdf5
