// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

#include "mbs/base/files/output.hpp"

namespace flexura::view {

/// An HTML file that grows piece by piece.  It may load nothing (its content security policy forbids it to).
/// Written beside and renamed by finish(): a file of this name is whole or not there.
/// All methods throw std::runtime_error, naming the file, when the file system refuses.
class HtmlFile {
 public:
  /// Writes the head with the title (any text) and the style sheet, and opens the body.
  HtmlFile(const std::filesystem::path& path, std::string_view title, std::string_view style);
  HtmlFile(const HtmlFile&) = delete;
  HtmlFile& operator=(const HtmlFile&) = delete;

  void put(std::string_view html);
  /// The script, the end; then the file gets its name.
  void finish(std::string_view script);

 private:
  [[noreturn]] void fail(std::string_view why);

  std::filesystem::path path_;
  files::Output file_;
  std::ofstream out_;
};

}  // namespace flexura::view
