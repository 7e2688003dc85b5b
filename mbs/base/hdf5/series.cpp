// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "mbs/base/hdf5/library.hpp"

namespace flexura::hdf5 {

Series Group::create_series(const std::string& name, std::size_t width, const std::string& unit,
                            const std::string& doc) {
  checked_name(name, label_);
  return writing([&] { return new_series(name, width, unit, doc); });
}

Series Group::new_series(const std::string& name, std::size_t width, const std::string& unit,
                         const std::string& doc) {
  const std::string full = child(label_, name);
  const int rank = width > 0 ? 2 : 1;
  const hsize_t start[2] = {0, width};
  const hsize_t most[2] = {H5S_UNLIMITED, width};
  // 8 kB of one quantity, 64 kB of many. No deflation: a chunk that is filled over several flushes would
  // change its size and be written elsewhere each time; of constant size it stays in place.
  const hsize_t chunk[2] = {width > 0 ? std::clamp<hsize_t>(8192 / width, 1, 1024) : 1024, width};
  const Handle space = owned(H5Screate_simple(rank, start, most), H5Sclose, full);
  const Handle properties = owned(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, full);
  check(H5Pset_obj_track_times(properties.get(), false), full);
  check(H5Pset_chunk(properties.get(), rank, chunk), full);
  check(H5Pset_fletcher32(properties.get()), full);
  Handle dataset = owned(H5Dcreate2(handle_.get(), checked_name(name, label_).c_str(), H5T_NATIVE_DOUBLE,
                                    space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                         H5Dclose, full);
  Series series(std::move(dataset), full, 0, width);
  if (!unit.empty()) series.set("unit", unit);
  if (!doc.empty()) series.set("doc", doc);
  return series;
}

Series Group::series(const std::string& name) const {
  const std::string full = child(label_, name);
  Handle dataset = open_dataset(name);
  const Shape shape = shape_of(dataset.get(), full);
  const Handle stored = owned(H5Dget_type(dataset.get()), H5Tclose, full);
  if (shape.empty() || shape.size() > 2 || H5Tget_class(stored.get()) != H5T_FLOAT) {
    throw BadFile(full + ": is not a series of numbers; the file is damaged or not what it says");
  }
  return Series(std::move(dataset), full, shape[0], shape.size() == 2 ? shape[1] : 0);
}

void Series::append(const double* rows, std::size_t n_rows) {
  writing([&] {
    if (n_rows == 0) return;
    const int rank = width_ > 0 ? 2 : 1;
    const hsize_t extent[2] = {n_rows_ + n_rows, width_}, start[2] = {n_rows_, 0},
                  count[2] = {n_rows, width_};
    check(H5Dset_extent(handle_.get(), extent), label_);
    const Handle file_space = owned(H5Dget_space(handle_.get()), H5Sclose, label_);
    check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start, nullptr, count, nullptr), label_);
    const Handle memory_space = owned(H5Screate_simple(rank, count, nullptr), H5Sclose, label_);
    check(H5Dwrite(handle_.get(), H5T_NATIVE_DOUBLE, memory_space.get(), file_space.get(), H5P_DEFAULT, rows),
          label_);
    n_rows_ += n_rows;
  });
}

std::vector<double> Series::read(std::size_t n_rows) const {
  const int rank = width_ > 0 ? 2 : 1;
  n_rows = std::min(n_rows, n_rows_);
  const std::size_t n_values = n_rows * std::max<std::size_t>(width_, 1);
  count_read(handle_.get(), 8.0 * static_cast<double>(n_values), label_);
  std::vector<double> values(n_values);
  if (values.empty()) return values;
  const hsize_t start[2] = {0, 0}, count[2] = {n_rows, width_};
  const Handle file_space = owned(H5Dget_space(handle_.get()), H5Sclose, label_);
  check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start, nullptr, count, nullptr), label_);
  const Handle memory_space = owned(H5Screate_simple(rank, count, nullptr), H5Sclose, label_);
  check(H5Dread(handle_.get(), H5T_NATIVE_DOUBLE, memory_space.get(), file_space.get(), H5P_DEFAULT,
                values.data()),
        label_);
  return values;
}

void Series::flush() {
  writing([&] { check(H5Dflush(handle_.get()), label_); });
}

}  // namespace flexura::hdf5
