// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>

#include "mbs/view/html/encode.hpp"
#include "mbs/view/html/html_file.hpp"

namespace flexura::view {

/// A page that its script draws (PAGE.md): data blocks one by one, then the header (JSON) and the script.
/// All methods throw std::runtime_error, naming the file, when the file system refuses.
class PageFile {
 public:
  PageFile(const std::filesystem::path& path, std::string_view title);

  /// A block of numbers, found by its name.  type is "i4", "f4", "f8" or "u2".
  void add_block(std::string_view name, std::string_view type, std::string_view base64);

  template <typename T>
  void add(std::string_view name, std::span<const T> values) {
    add_block(name, type_name<T>(), encode_block(values));
  }

  /// The header, the script, the end; then the file gets its name.
  void finish(const nlohmann::json& header);

 private:
  template <typename T>
  static constexpr std::string_view type_name() {
    if constexpr (std::is_same_v<T, std::int32_t>) return "i4";
    if constexpr (std::is_same_v<T, float>) return "f4";
    if constexpr (std::is_same_v<T, double>) return "f8";
    if constexpr (std::is_same_v<T, std::uint16_t>) return "u2";
  }

  HtmlFile file_;
};

}  // namespace flexura::view
