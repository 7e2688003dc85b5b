// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/hdf5/file.hpp"

#include <hdf5.h>

#include <algorithm>
#include <fstream>
#include <type_traits>

namespace flexura::hdf5 {
namespace {

static_assert(std::is_same_v<hid_t, std::int64_t>);

// --- Errors ----------------------------------------------------------------------------------------------

// HDF5 prints a stack of a dozen lines; we keep it quiet and make one sentence of it.
void silence() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

herr_t collect(unsigned, const H5E_error2_t* entry, void* out) {
  auto& lines = *static_cast<std::vector<std::string>*>(out);
  if (entry->desc) lines.emplace_back(entry->desc);
  return 0;
}

constexpr const char* writing_mark =
    "another program is writing it, or was killed while it set the file up; wait or make it again";

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
  for (const std::string& line : lines) {  // the operating system's own words
    const std::string key = "error message = '";
    if (const auto at = line.find(key); at != std::string::npos) {
      const auto start = at + key.size();
      return line.substr(start, line.find('\'', start) - start);
    }
  }
  return lines.empty() ? "HDF5 gives no reason"
                       : "the file is damaged (" + lines.front() + "); make it again";
}

[[noreturn]] void fail(const std::string& label) {
  throw BadFile(label + ": " + reason());
}

// While writing: the disk or the folder is to blame, not the input.
template <typename Work>
auto writing(Work&& work) {
  try {
    return work();
  } catch (const BadFile& failure) {
    throw Error(failure.what());
  }
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

std::string shape_text(const Shape& shape) {
  std::string text;
  for (const std::size_t n : shape) text += (text.empty() ? "" : " x ") + std::to_string(n);
  return text.empty() ? "a single value" : text;
}

Shape shape_of(hid_t dataset, const std::string& label) {
  const Handle space = owned(H5Dget_space(dataset), H5Sclose, label);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0 || rank > 8) fail(label);
  std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
  if (rank > 0) check(H5Sget_simple_extent_dims(space.get(), extent.data(), nullptr), label);
  return Shape(extent.begin(), extent.end());
}

// --- Filters ---------------------------------------------------------------------------------------------

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

const std::string& checked_name(const std::string& name, const std::string& label) {
  if (name.empty() || name == "." || name.find('/') != std::string::npos) {
    throw BadFile(label + ": \"" + name + "\" cannot be a name in an HDF5 file; use a name without \"/\"");
  }
  return name;
}

Handle text_type(std::size_t length, const std::string& label) {
  Handle type = owned(H5Tcopy(H5T_C_S1), H5Tclose, label);
  check(H5Tset_size(type.get(), std::max<std::size_t>(length, 1)), label);
  check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), label);
  check(H5Tset_cset(type.get(), H5T_CSET_UTF8), label);
  return type;
}

void write_attribute(hid_t node, const std::string& name, hid_t type, const void* data,
                     const std::string& label) {
  const std::string full = label + " (" + name + ")";
  if (H5Aexists(node, name.c_str()) > 0) check(H5Adelete(node, name.c_str()), full);
  const Handle space = owned(H5Screate(H5S_SCALAR), H5Sclose, full);
  const Handle attribute =
      owned(H5Acreate2(node, name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose, full);
  check(H5Awrite(attribute.get(), type, data), full);
}

Handle open_attribute(hid_t node, const std::string& name, const std::string& label) {
  if (H5Aexists(node, name.c_str()) <= 0) {
    H5Eclear2(H5E_DEFAULT);
    throw BadFile(label + ": has no attribute " + name);
  }
  Handle attribute = owned(H5Aopen(node, name.c_str(), H5P_DEFAULT), H5Aclose, label);
  // Only single values: anything else was not written by us, and must not be read into a single variable.
  const Handle space = owned(H5Aget_space(attribute.get()), H5Sclose, label);
  if (H5Sget_simple_extent_npoints(space.get()) != 1)
    throw BadFile(label + ": attribute " + name + " is no single value");
  return attribute;
}

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

}  // namespace

// --- Handles and attributes ------------------------------------------------------------------------------

Handle& Handle::operator=(Handle&& other) noexcept {
  if (this != &other) {
    close();
    id_ = other.id_;
    closer_ = other.closer_;
    other.id_ = -1;
  }
  return *this;
}

int Handle::close() {
  if (id_ < 0) return 0;
  const std::int64_t id = id_;
  id_ = -1;
  return closer_(id);
}

void Node::set(const std::string& attribute, const std::string& text) {
  const Handle type = text_type(text.size(), label_);
  std::string padded = text;
  if (padded.empty()) padded.push_back('\0');
  write_attribute(handle_.get(), attribute, type.get(), padded.data(), label_);
}
void Node::set(const std::string& attribute, double number) {
  write_attribute(handle_.get(), attribute, H5T_NATIVE_DOUBLE, &number, label_);
}
void Node::set(const std::string& attribute, int number) {
  write_attribute(handle_.get(), attribute, H5T_NATIVE_INT, &number, label_);
}

bool Node::has_attribute(const std::string& attribute) const {
  return H5Aexists(handle_.get(), attribute.c_str()) > 0;
}

std::string Node::text(const std::string& name) const {
  const Handle attribute = open_attribute(handle_.get(), name, label_);
  const Handle type = owned(H5Aget_type(attribute.get()), H5Tclose, label_);
  if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) > 0) {
    throw BadFile(label_ + ": attribute " + name + " is not a text");
  }
  const std::size_t size = H5Tget_size(type.get());
  if (size == 0) fail(label_);
  const Handle memory = text_type(size, label_);
  std::string text(size, '\0');
  check(H5Aread(attribute.get(), memory.get(), text.data()), label_);
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  return text;
}

double Node::number(const std::string& name) const {
  const Handle attribute = open_attribute(handle_.get(), name, label_);
  double number = 0.0;
  check(H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &number), label_);
  return number;
}

int Node::integer(const std::string& name) const {
  const Handle attribute = open_attribute(handle_.get(), name, label_);
  int number = 0;
  check(H5Aread(attribute.get(), H5T_NATIVE_INT, &number), label_);
  return number;
}

// --- Groups and datasets ---------------------------------------------------------------------------------

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
  return Group(owned(H5Gcreate2(handle_.get(), checked_name(name, label_).c_str(), H5P_DEFAULT, H5P_DEFAULT,
                                H5P_DEFAULT),
                     H5Gclose, full),
               full);
}

Group Group::group(const std::string& name) const {
  const std::string full = child(label_, name);
  if (!has(name)) throw BadFile(full + ": is missing; the file is not complete, make it again");
  return Group(owned(H5Gopen2(handle_.get(), name.c_str(), H5P_DEFAULT), H5Gclose, full), full);
}

Handle Group::open_dataset(const std::string& name) const {
  const std::string full = child(label_, name);
  if (!has(name)) throw BadFile(full + ": is missing; the file is not complete, make it again");
  return owned(H5Dopen2(handle_.get(), name.c_str(), H5P_DEFAULT), H5Dclose, full);
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
  constexpr std::size_t longest = std::size_t{1} << 30;
  if (found.size() != 1 || found[0] > longest) throw BadFile(child(label_, name) + ": is not a text");
  std::string text(found[0], '\0');
  read_raw(name, found, H5T_NATIVE_UINT8, text.data());
  return text;
}

// --- Series ----------------------------------------------------------------------------------------------

Series Group::create_series(const std::string& name, std::size_t width, const std::string& unit,
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
  std::vector<double> values(n_rows * std::max<std::size_t>(width_, 1));
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
  check(H5Dflush(handle_.get()), label_);
}

// --- Files -----------------------------------------------------------------------------------------------

File::File(const std::filesystem::path& path, Mode mode) : path_(path) {
  silence();
  const std::string label = path.string();
  std::error_code ignored;
  if (mode != Mode::create) {
    if (!std::filesystem::exists(path, ignored))
      throw BadFile(label + ": there is no such file; check the path");
    if (std::filesystem::is_directory(path, ignored))
      throw BadFile(label + ": is a folder, a file is wanted");
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
    case Mode::create:
      id = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get());
      break;
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
  check(H5Fflush(handle_.get(), H5F_SCOPE_LOCAL), path_.string());
}

void File::close() {
  writing([&] {
    if (!handle_.is_open()) return;
    const herr_t flushed = H5Fflush(handle_.get(), H5F_SCOPE_LOCAL);
    const std::string why = flushed < 0 ? reason() : "";
    const int closed = handle_.close();
    if (flushed < 0) throw BadFile(path_.string() + ": " + why);
    check(closed, path_.string());
  });
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
  RowMajor rows(n_rows, n_columns);
  group.read(name, {static_cast<std::size_t>(n_rows), static_cast<std::size_t>(n_columns)}, rows.data());
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
