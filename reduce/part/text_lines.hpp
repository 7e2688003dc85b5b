// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <zlib.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace flexura::reduce {

/// Of a packed text no more is unpacked, and of a matrix no more numbers are held, than a file of its size can mean: 13 MB can be
/// made of 3 GB of blanks.  Matrices as programs print them pack to a third or a tenth.
double most_of(const std::filesystem::path& path);

/// The lines of a text file, packed by gzip or not.
class Lines {
 public:
  /// Throws std::invalid_argument where there is no such file.
  explicit Lines(const std::filesystem::path& path);

  /// False at the end of the file.
  bool next(std::string& line);
  int number() const { return number_; }
  /// Throws std::invalid_argument with file and line.
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  std::filesystem::path path_;
  std::unique_ptr<gzFile_s, int (*)(gzFile)> file_;
  double most_;  // bytes
  int number_ = 0;
};

/// Calls with the numbers of each line that is neither blank nor a comment; commas are blanks.
void for_each_line(const std::filesystem::path& path,
                   const std::function<void(const std::vector<double>&, int line)>& work);

}  // namespace flexura::reduce
