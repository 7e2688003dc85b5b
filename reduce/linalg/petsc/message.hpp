// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace flexura::linalg {

/// Numbers and arrays of numbers one after the other, as processes hand them to one another; taken in the
/// order in which they were put.
class Message {
 public:
  Message() = default;
  explicit Message(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  const std::vector<std::byte>& bytes() const { return bytes_; }

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { put_array(&value, 1); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put_array(const T* values, std::size_t count) {
    const auto* from = reinterpret_cast<const std::byte*>(values);
    bytes_.insert(bytes_.end(), from, from + count * sizeof(T));
  }
  template <class Range>
  void put_all(const Range& values) {
    put(static_cast<std::size_t>(values.size()));
    put_array(values.data(), static_cast<std::size_t>(values.size()));
  }

  template <class T>
  T take() {
    T value{};
    take_array(&value, 1);
    return value;
  }
  template <class T>
  void take_array(T* values, std::size_t count) {
    if (bytes_.size() - place_ < count * sizeof(T)) throw std::logic_error("a message ends too early");
    std::memcpy(static_cast<void*>(values), bytes_.data() + place_, count * sizeof(T));
    place_ += count * sizeof(T);
  }
  template <class T>
  std::vector<T> take_all() {
    std::vector<T> values(take<std::size_t>());
    take_array(values.data(), values.size());
    return values;
  }
  std::string take_text() {
    const std::vector<char> text = take_all<char>();
    return {text.begin(), text.end()};
  }

 private:
  std::vector<std::byte> bytes_;
  std::size_t place_ = 0;
};

}  // namespace flexura::linalg
