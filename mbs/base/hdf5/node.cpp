// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "mbs/base/files/plain_text.hpp"
#include "mbs/base/hdf5/library.hpp"

namespace flexura::hdf5 {
namespace {

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

}  // namespace

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
  return files::plain_text(text);
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

}  // namespace flexura::hdf5
