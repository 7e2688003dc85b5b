// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

/// The few things we ask of HDF5, with handles that close themselves and errors of one sentence.
///
/// Every dataset is chunked, shuffled, deflated and carries a Fletcher-32 checksum over the deflated bytes;
/// all metadata is written in the 1.10 format, whose blocks carry checksums of their own.  Texts are byte
/// datasets or fixed-length attributes, never variable-length strings: those live in the global heap, which
/// has no checksum. So a flipped byte in anything that means something is noticed.  Only this
/// folder's library.hpp sees hdf5.h.
namespace flexura::hdf5 {

/// "FILE: /path/in/file: what is wrong; remedy".
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An error while reading: what is wrong is the file, and so the input of the program.
class BadFile : public Error {
 public:
  using Error::Error;
};

/// Lets the library start while there is memory: it does not survive when that fails within its own start.
void start();

using Shape = std::vector<std::size_t>;

/// Owns one HDF5 identifier.
class Handle {
 public:
  using Closer = int (*)(std::int64_t);
  Handle() = default;
  Handle(std::int64_t id, Closer closer) : id_(id), closer_(closer) {}
  Handle(Handle&& other) noexcept : id_(other.id_), closer_(other.closer_) { other.id_ = -1; }
  Handle& operator=(Handle&& other) noexcept;
  ~Handle() { close(); }
  std::int64_t get() const { return id_; }
  bool is_open() const { return id_ >= 0; }
  int close();  ///< negative when HDF5 failed, for example on a full disk

 private:
  std::int64_t id_ = -1;
  Closer closer_ = nullptr;
};

/// A group or dataset: something with attributes.
class Node {
 public:
  void set(const std::string& attribute, const std::string& text);
  void set(const std::string& attribute, double number);
  void set(const std::string& attribute, int number);
  bool has_attribute(const std::string& attribute) const;
  std::string text(const std::string& attribute) const;
  double number(const std::string& attribute) const;
  int integer(const std::string& attribute) const;
  /// "FILE: /path", as messages name it.
  const std::string& label() const { return label_; }

 protected:
  Node(Handle handle, std::string label) : handle_(std::move(handle)), label_(std::move(label)) {}
  Handle handle_;
  std::string label_;
};

/// A dataset of doubles that grows by rows: n_t, or n_t x width when width > 0.
class Series : public Node {
 public:
  void append(const double* rows, std::size_t n_rows);
  std::size_t n_rows() const { return n_rows_; }
  std::size_t width() const { return width_; }
  /// The first n_rows rows, row by row.
  std::vector<double> read(std::size_t n_rows) const;
  void flush();

 private:
  friend class Group;
  Series(Handle handle, std::string label, std::size_t n_rows, std::size_t width)
      : Node(std::move(handle), std::move(label)), n_rows_(n_rows), width_(width) {}
  std::size_t n_rows_ = 0, width_ = 0;
};

class Group : public Node {
 public:
  bool has(const std::string& name) const;
  std::vector<std::string> names() const;  ///< in alphabetical order
  Group create_group(const std::string& name);
  Group group(const std::string& name) const;

  /// Row-major data of the given shape; `unit` and `doc` become attributes, so that the file explains itself.
  void write(const std::string& name, const Shape& shape, const double* data, const std::string& unit,
             const std::string& doc);
  void write(const std::string& name, const Shape& shape, const float* data, const std::string& unit,
             const std::string& doc);
  void write(const std::string& name, const Shape& shape, const std::int32_t* data, const std::string& unit,
             const std::string& doc);
  void write_text(const std::string& name, const std::string& text, const std::string& doc);

  Shape shape(const std::string& name) const;
  /// Read a dataset whose shape must be `wanted`; nothing is allocated before that is checked.
  void read(const std::string& name, const Shape& wanted, double* data) const;
  void read(const std::string& name, const Shape& wanted, float* data) const;
  void read(const std::string& name, const Shape& wanted, std::int32_t* data) const;
  std::string read_text(const std::string& name) const;

  Series create_series(const std::string& name, std::size_t width, const std::string& unit,
                       const std::string& doc);
  Series series(const std::string& name) const;

 private:
  friend class File;
  Group(Handle handle, std::string label) : Node(std::move(handle), std::move(label)) {}
  void write_raw(const std::string& name, const Shape& shape, std::int64_t type, std::size_t type_size,
                 const void* data, const std::string& unit, const std::string& doc);
  void read_raw(const std::string& name, const Shape& wanted, std::int64_t type, void* data) const;
  Handle open_dataset(const std::string& name) const;
  Series new_series(const std::string& name, std::size_t width, const std::string& unit,
                    const std::string& doc);
};

enum class Mode {
  create,  ///< a new file, replacing what is there
  read,    ///< also a file that a Mode::append writer still has open, or had when it was killed
  modify,  ///< add groups, datasets, attributes
  append,  ///< only extend series; whatever kills the program, the file stays readable
};

class File {
 public:
  File(const std::filesystem::path& path, Mode mode);
  Group root() const;
  void flush();
  /// Closes and reports what the destructor would have to swallow.
  void close();

 private:
  Handle handle_;
  std::filesystem::path path_;
};

/// Dense matrices are stored row by row, as they are printed; so Octave, which reads transposed, and numpy,
/// which does not, are both served by the attribute "shape" in the documentation.
void write_matrix(Group& group, const std::string& name, const Eigen::MatrixXd& matrix,
                  const std::string& unit, const std::string& doc);
Eigen::MatrixXd read_matrix(const Group& group, const std::string& name, Eigen::Index n_rows,
                            Eigen::Index n_columns);
void write_vector(Group& group, const std::string& name, const Eigen::VectorXd& vector,
                  const std::string& unit, const std::string& doc);
Eigen::VectorXd read_vector(const Group& group, const std::string& name, Eigen::Index n);

}  // namespace flexura::hdf5
