// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "mbs/base/hdf5/library.hpp"

namespace flexura::hdf5 {
namespace {

constexpr std::size_t chunk_bytes = 1 << 20;  // one chunk of a large dataset: fits HDF5's chunk cache
constexpr unsigned deflate_level = 2;  // higher levels gain a few percent on shuffled doubles and cost double

// Whole rows, at most chunk_bytes of them.
std::vector<hsize_t> chunk_shape(const Shape& shape, std::size_t type_size) {
  std::vector<hsize_t> chunk(shape.begin(), shape.end());
  std::size_t row = type_size;
  for (std::size_t i = 1; i < shape.size(); ++i) row *= shape[i];
  chunk[0] = std::clamp<std::size_t>(chunk_bytes / std::max<std::size_t>(row, 1), 1, shape[0]);
  // A single row may be larger than that: cut it, too (HDF5 allows chunks below 4 GiB only).
  for (std::size_t i = 1; i < shape.size() && row > chunk_bytes; ++i) {
    row /= shape[i];
    chunk[i] = std::clamp<std::size_t>(chunk_bytes / std::max<std::size_t>(row, 1), 1, shape[i]);
    row *= chunk[i];
  }
  return chunk;
}

std::string shape_text(const Shape& shape) {
  std::string text;
  for (const std::size_t n : shape) text += (text.empty() ? "" : " x ") + std::to_string(n);
  return text.empty() ? "a single value" : text;
}

// A file that came from elsewhere must not make us read others: links to other files, and links that lead to
// such links, are no more followed than data that lie outside.
void require_inside(hid_t group, const std::string& name, const std::string& full) {
  H5L_info_t info;
  check(H5Lget_info(group, name.c_str(), &info, H5P_DEFAULT), full);
  if (info.type != H5L_TYPE_HARD)
    throw BadFile(full + ": is a link, which may lead out of the file; write the data into the file itself");
}

void require_own_data(hid_t dataset, const std::string& full) {
  const Handle properties = owned(H5Dget_create_plist(dataset), H5Pclose, full);
  if (H5Pget_layout(properties.get()) == H5D_VIRTUAL || H5Pget_external_count(properties.get()) > 0)
    throw BadFile(full + ": has its data in another file; write them into the file itself");
}

}  // namespace

bool Group::has(const std::string& name) const {
  const htri_t found = H5Lexists(handle_.get(), checked_name(name, label_).c_str(), H5P_DEFAULT);
  if (found < 0) fail(child(label_, name));
  return found > 0;
}

std::vector<std::string> Group::names() const {
  std::vector<std::string> names;
  hsize_t index = 0;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  check(H5Literate(handle_.get(), H5_INDEX_NAME, H5_ITER_INC, &index, add, &names), label_);
  return names;
}

Group Group::create_group(const std::string& name) {
  const std::string full = child(label_, name);
  checked_name(name, label_);
  return writing([&] {
    const Handle properties = owned(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, full);
    check(H5Pset_obj_track_times(properties.get(), false), full);  // equal content gives equal bytes
    return Group(owned(H5Gcreate2(handle_.get(), name.c_str(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                       H5Gclose, full),
                 full);
  });
}

Group Group::group(const std::string& name) const {
  const std::string full = child(label_, name);
  if (!has(name)) throw BadFile(full + ": is missing; the file is not complete, make it again");
  require_inside(handle_.get(), name, full);
  return Group(owned(H5Gopen2(handle_.get(), name.c_str(), H5P_DEFAULT), H5Gclose, full), full);
}

Handle Group::open_dataset(const std::string& name) const {
  const std::string full = child(label_, name);
  if (!has(name)) throw BadFile(full + ": is missing; the file is not complete, make it again");
  require_inside(handle_.get(), name, full);
  Handle dataset = owned(H5Dopen2(handle_.get(), name.c_str(), H5P_DEFAULT), H5Dclose, full);
  require_own_data(dataset.get(), full);
  require_stored(dataset.get(), full);
  return dataset;
}

Shape Group::shape(const std::string& name) const {
  return shape_of(open_dataset(name).get(), child(label_, name));
}

void Group::write_raw(const std::string& name, const Shape& shape, std::int64_t type, std::size_t type_size,
                      const void* data, const std::string& unit, const std::string& doc) {
  writing([&] {
    const std::string full = child(label_, name);
    const std::vector<hsize_t> extent(shape.begin(), shape.end());
    const Handle space =
        owned(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose, full);
    const Handle properties = owned(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, full);
    check(H5Pset_obj_track_times(properties.get(), false), full);  // equal content gives equal bytes
    if (std::find(shape.begin(), shape.end(), 0u) == shape.end()) {
      const std::vector<hsize_t> chunk = chunk_shape(shape, type_size);
      check(H5Pset_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data()), full);
      if (type_size > 1) check(H5Pset_shuffle(properties.get()), full);
      check(H5Pset_deflate(properties.get(), deflate_level), full);
      check(H5Pset_fletcher32(properties.get()), full);
    }
    Handle dataset = owned(H5Dcreate2(handle_.get(), checked_name(name, label_).c_str(), type, space.get(),
                                      H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                           H5Dclose, full);
    check(H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), full);
    Group attributes(std::move(dataset), full);
    if (!unit.empty()) attributes.set("unit", unit);
    if (!doc.empty()) attributes.set("doc", doc);
    // The last chunks are written here, and only here a full disk is told of.
    check(attributes.handle_.close(), full);
  });
}

void Group::read_raw(const std::string& name, const Shape& wanted, std::int64_t type, void* data) const {
  const std::string full = child(label_, name);
  const Handle dataset = open_dataset(name);
  if (const Shape found = shape_of(dataset.get(), full); found != wanted) {
    throw BadFile(full + ": has the shape " + shape_text(found) + ", " + shape_text(wanted) +
                  " is wanted; the file is damaged or not what it says");
  }
  const Handle stored = owned(H5Dget_type(dataset.get()), H5Tclose, full);
  if (H5Tget_class(stored.get()) != H5Tget_class(type) || H5Tget_size(stored.get()) != H5Tget_size(type)) {
    throw BadFile(full +
                  ": has another number type than the format says; the file is damaged or not what it says");
  }
  double bytes = static_cast<double>(H5Tget_size(type));
  for (const std::size_t n : wanted) bytes *= static_cast<double>(n);
  count_read(dataset.get(), bytes, full);
  check(H5Dread(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), full);
}

void Group::write(const std::string& name, const Shape& shape, const double* data, const std::string& unit,
                  const std::string& doc) {
  write_raw(name, shape, H5T_NATIVE_DOUBLE, sizeof(double), data, unit, doc);
}
void Group::write(const std::string& name, const Shape& shape, const float* data, const std::string& unit,
                  const std::string& doc) {
  write_raw(name, shape, H5T_NATIVE_FLOAT, sizeof(float), data, unit, doc);
}
void Group::write(const std::string& name, const Shape& shape, const std::int32_t* data,
                  const std::string& unit, const std::string& doc) {
  write_raw(name, shape, H5T_NATIVE_INT32, sizeof(std::int32_t), data, unit, doc);
}
void Group::write_text(const std::string& name, const std::string& text, const std::string& doc) {
  write_raw(name, {text.size()}, H5T_NATIVE_UINT8, 1, text.data(), "", doc);
}

void Group::read(const std::string& name, const Shape& wanted, double* data) const {
  read_raw(name, wanted, H5T_NATIVE_DOUBLE, data);
}
void Group::read(const std::string& name, const Shape& wanted, float* data) const {
  read_raw(name, wanted, H5T_NATIVE_FLOAT, data);
}
void Group::read(const std::string& name, const Shape& wanted, std::int32_t* data) const {
  read_raw(name, wanted, H5T_NATIVE_INT32, data);
}

std::string Group::read_text(const std::string& name) const {
  const Shape found = shape(name);
  constexpr std::size_t longest = std::size_t{1} << 28;
  if (found.size() != 1 || found[0] > longest) throw BadFile(child(label_, name) + ": is not a text");
  std::string text(found[0], '\0');
  read_raw(name, found, H5T_NATIVE_UINT8, text.data());
  return text;
}

// --- Eigen -----------------------------------------------------------------------------------------------

namespace {
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
}

void write_matrix(Group& group, const std::string& name, const Eigen::MatrixXd& matrix,
                  const std::string& unit, const std::string& doc) {
  const RowMajor rows = matrix;
  group.write(name, {static_cast<std::size_t>(rows.rows()), static_cast<std::size_t>(rows.cols())},
              rows.data(), unit, doc);
}

Eigen::MatrixXd read_matrix(const Group& group, const std::string& name, Eigen::Index n_rows,
                            Eigen::Index n_columns) {
  const Shape wanted = {static_cast<std::size_t>(n_rows), static_cast<std::size_t>(n_columns)};
  // Before there is room for it.
  if (group.shape(name) != wanted) group.read(name, wanted, static_cast<double*>(nullptr));
  RowMajor rows(n_rows, n_columns);
  group.read(name, wanted, rows.data());
  return rows;
}

void write_vector(Group& group, const std::string& name, const Eigen::VectorXd& vector,
                  const std::string& unit, const std::string& doc) {
  group.write(name, {static_cast<std::size_t>(vector.size())}, vector.data(), unit, doc);
}

Eigen::VectorXd read_vector(const Group& group, const std::string& name, Eigen::Index n) {
  Eigen::VectorXd vector(n);
  group.read(name, {static_cast<std::size_t>(n)}, vector.data());
  return vector;
}

}  // namespace flexura::hdf5
