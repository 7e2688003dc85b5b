// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/text_lines.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace flexura::reduce {

double most_of(const std::filesystem::path& path) {
  std::error_code none;
  const std::uintmax_t size = std::filesystem::file_size(path, none);
  return none ? 0.0 : 1e7 + 20.0 * static_cast<double>(size);
}

Lines::Lines(const std::filesystem::path& path)
    : path_(path), file_(gzopen(path.c_str(), "rb"), gzclose), most_(most_of(path)) {
  if (!file_) throw std::invalid_argument(path.string() + ": there is no such file; check the path");
}

bool Lines::next(std::string& line) {
  constexpr std::size_t longest = 2'000'000;  // a row of 20,000 modes has a quarter of that
  char buffer[4096];
  line.clear();
  ++number_;
  while (gzgets(file_.get(), buffer, sizeof buffer) != nullptr) {
    line += buffer;
    if (static_cast<double>(gztell(file_.get())) > most_)
      refuse("unpacks to more than 20 times the file's size; give the matrix unpacked");
    if (line.size() > longest)
      refuse(fmt::format("is longer than {} letters; give a matrix, a row on each line", longest));
    if (line.empty()) refuse("holds a zero character; a text file is wanted");
    if (line.back() == '\n') return true;
  }
  int code = Z_OK;
  gzerror(file_.get(), &code);
  if (code != Z_OK && code != Z_STREAM_END) refuse("cannot be unpacked; the file is damaged or cut short");
  return !line.empty();
}

void Lines::refuse(const std::string& what) const {
  throw std::invalid_argument(fmt::format("{}, line {}: {}", path_.string(), number_, what));
}

void for_each_line(const std::filesystem::path& path,
                   const std::function<void(const std::vector<double>&, int line)>& work) {
  Lines lines(path);
  std::vector<double> numbers;
  for (std::string text; lines.next(text);) {
    numbers.clear();
    for (const char* at = text.c_str(); *at != '\0';) {
      while (*at == ',' || std::isspace(static_cast<unsigned char>(*at))) ++at;
      if (*at == '\0' || *at == '#' || *at == '%' || *at == '*') break;
      char* end = nullptr;
      const double value = std::strtod(at, &end);
      if (end == at) lines.refuse("a number is wanted");
      if (!std::isfinite(value)) lines.refuse("an entry is not finite");
      numbers.push_back(value);
      at = end;
    }
    if (!numbers.empty()) work(numbers, lines.number());
  }
}

}  // namespace flexura::reduce
