// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/op4.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <vector>

namespace flexura::reduce {
namespace {

using Begin = std::function<bool(const Op4Head&)>;  // whether the entries are wanted
using Take = std::function<void(std::int64_t, std::int64_t, double)>;

constexpr std::int64_t kMostRows = 1'000'000'000;
constexpr std::int64_t kBigMat = 65536;  // from so many rows on strings have their row in a word of its own

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& what) {
  throw std::invalid_argument(fmt::format("{}: {}", path.string(), what));
}

/// What both forms have in common: words and numbers, one after another.
class Source {
 public:
  explicit Source(const std::filesystem::path& path) : path_(path) {}
  virtual ~Source() = default;
  /// The next matrix; false at the end.  `rows` is negative for BIGMAT.
  virtual bool head(std::string& name, std::int64_t& rows, std::int64_t& columns, int& type) = 0;
  /// Column, row (0: strings follow) and number of words; ends the column before.
  virtual std::array<std::int64_t, 3> column() = 0;
  virtual std::array<std::int64_t, 2> big_string() = 0;  // length in words and one more, row
  virtual std::int64_t small_string() = 0;               // both in one word
  virtual void numbers(std::int64_t count, std::vector<double>& out) = 0;
  /// Words of a number in strings, and in whole columns.
  virtual int words_in_strings() const = 0;
  virtual int words_in_columns() const = 0;
  virtual void end() = 0;

  [[noreturn]] void fail(const std::string& what) const {
    refuse(path_, what + "; write it again by OUTPUT4");
  }

 private:
  std::filesystem::path path_;
};

class BinarySource final : public Source {
 public:
  BinarySource(const std::filesystem::path& path, std::string text) : Source(path), text_(std::move(text)) {
    const std::uint32_t length = word32(0);
    swaps_ = length != 24 && length != 48;
    wide_ = (swaps_ ? swapped(length) : length) == 48;
    if ((swaps_ ? swapped(length) : length) != 24 && !wide_)
      fail("its first record has neither 24 nor 48 bytes, as that of an OUTPUT4 file does");
  }
  bool head(std::string& name, std::int64_t& rows, std::int64_t& columns, int& type) override {
    if (at_ == text_.size()) return false;
    open();
    columns = integer(), rows = integer();
    integer();  // the form: all entries are there whatever it is
    type = static_cast<int>(integer());
    name = text_.substr(at_, wide_ ? 16 : 8);
    close();
    type_ = type;
    return true;
  }
  std::array<std::int64_t, 3> column() override {
    if (inside_) close();
    open();
    std::array<std::int64_t, 3> out{};
    for (std::int64_t& x : out) x = integer();
    return out;
  }
  std::array<std::int64_t, 2> big_string() override {
    const std::int64_t length = integer(), row = integer();
    return {length, row};
  }
  std::int64_t small_string() override { return integer(); }
  void numbers(std::int64_t count, std::vector<double>& out) override {
    const std::size_t size = type_ == 1 && !wide_ ? 4 : 8;
    if (count < 0 || static_cast<std::size_t>(count) > (record_end_ - at_) / size)
      fail("a column has more numbers than its record");
    out.resize(static_cast<std::size_t>(count));
    for (double& x : out) {
      x = size == 4 ? static_cast<double>(std::bit_cast<float>(read32())) : std::bit_cast<double>(read64());
    }
  }
  int words_in_strings() const override { return type_ == 2 && !wide_ ? 2 : 1; }
  int words_in_columns() const override { return words_in_strings(); }
  void end() override { close(); }

 private:
  static std::uint32_t swapped(std::uint32_t x) {
    return x >> 24 | (x >> 8 & 0xFF00U) | (x << 8 & 0xFF0000U) | x << 24;
  }
  std::uint32_t word32(std::size_t at) const {
    if (at + 4 > text_.size()) fail("it ends in the middle of a matrix");
    std::uint32_t x = 0;
    std::memcpy(&x, text_.data() + at, 4);
    return swaps_ ? swapped(x) : x;
  }
  std::uint32_t read32() {
    const std::uint32_t x = word32(at_);
    at_ += 4;
    return x;
  }
  std::uint64_t read64() {
    const std::uint64_t a = read32(), b = read32();
    return swaps_ == (std::endian::native == std::endian::little) ? a << 32 | b : b << 32 | a;
  }
  std::int64_t integer() {
    if (record_end_ - at_ < (wide_ ? 8U : 4U)) fail("a record is too short");
    return wide_ ? static_cast<std::int64_t>(read64()) : static_cast<std::int32_t>(read32());
  }
  void open() {
    const std::uint32_t length = read32();
    if (length > text_.size() - at_) fail("it ends in the middle of a matrix");
    record_end_ = at_ + length;
    inside_ = true;
  }
  void close() {
    const std::size_t begin = at_;
    at_ = record_end_;
    if (begin > record_end_) fail("a record is shorter than what it holds");
    read32();
    inside_ = false;
  }

  std::string text_;
  std::size_t at_ = 0, record_end_ = 0;
  bool swaps_ = false, wide_ = false, inside_ = false;
  int type_ = 2;
};

class FormattedSource final : public Source {
 public:
  FormattedSource(const std::filesystem::path& path, std::string text)
      : Source(path), text_(std::move(text)) {}
  bool head(std::string& name, std::int64_t& rows, std::int64_t& columns, int& type) override {
    std::string_view line;
    do {
      if (at_ >= text_.size()) return false;
      line = next();
    } while (line.find_first_not_of(" \r") == line.npos);
    columns = integer(line, 0), rows = integer(line, 8);
    type = static_cast<int>(integer(line, 24));
    name = std::string(line.substr(std::min<std::size_t>(32, line.size())).substr(0, 8));
    // "1P,3E23.16": three numbers of 23 columns a line.
    per_line_ = 5, width_ = 16;
    if (line.size() > 40) {
      std::string format(line.substr(40));
      for (char& c : format) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      const std::size_t comma = format.find(','), first = comma == format.npos ? 0 : comma + 1,
                        letter = format.find_first_of("ED", first);
      if (letter != format.npos) {
        per_line_ = std::atoi(format.c_str() + first);
        width_ = std::atoi(format.c_str() + letter + 1);
      }
    }
    if (per_line_ < 1 || width_ < 1 || per_line_ > 1000 || width_ > 1000)
      fail(fmt::format("line {} has no format of numbers like 1P,3E23.16", number_));
    type_ = type;
    return true;
  }
  std::array<std::int64_t, 3> column() override {
    const std::string_view line = next();
    return {integer(line, 0), integer(line, 8), integer(line, 16)};
  }
  std::array<std::int64_t, 2> big_string() override {
    const std::string_view line = next();
    return {integer(line, 0), integer(line, 8)};
  }
  std::int64_t small_string() override {
    const std::string word(next());
    return std::strtoll(word.c_str(), nullptr, 10);
  }
  void numbers(std::int64_t count, std::vector<double>& out) override {
    if (count < 0 || static_cast<std::size_t>(count) > text_.size())
      fail(fmt::format("line {} cannot be", number_));
    out.clear();
    while (std::ssize(out) < count) {
      const std::string_view line = next();
      for (int k = 0; k < per_line_ && std::ssize(out) < count; ++k) out.push_back(real(line, k));
    }
  }
  int words_in_strings() const override { return type_ == 2 ? 2 : 1; }
  int words_in_columns() const override { return 1; }
  void end() override {}

 private:
  std::string_view next() {
    if (at_ >= text_.size()) fail("it ends in the middle of a matrix");
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    const std::string_view line = std::string_view(text_).substr(at_, end - at_);
    at_ = end + 1;
    ++number_;
    return line;
  }
  std::int64_t integer(std::string_view line, std::size_t at) const {
    const std::string field(line.size() > at ? line.substr(at, 8) : "");
    char* end = nullptr;
    const std::int64_t value = std::strtoll(field.c_str(), &end, 10);
    if (end == field.c_str())
      fail(fmt::format("line {} has no whole number in columns {} to {}", number_, at + 1, at + 8));
    return value;
  }
  double real(std::string_view line, int k) const {
    const auto at = static_cast<std::size_t>(k) * static_cast<std::size_t>(width_);
    std::string field(line.size() > at ? line.substr(at, static_cast<std::size_t>(width_)) : "");
    std::ranges::replace(field, 'D', 'E');
    char* end = nullptr;
    const double value = std::strtod(field.c_str(), &end);
    if (end == field.c_str()) fail(fmt::format("line {} lacks a number in column {}", number_, at + 1));
    return value;
  }

  std::string text_;
  std::size_t at_ = 0;
  int number_ = 0, per_line_ = 5, width_ = 16, type_ = 2;
};

std::unique_ptr<Source> open_op4(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) refuse(path, "cannot be read; check the path");
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (text.size() < 16) refuse(path, "is no OUTPUT4 file: it has less than 16 bytes; write the matrix anew");
  // A record begins with its length, of which three bytes are zero, which no text has.
  if (text[1] == '\0' && text[2] == '\0') return std::make_unique<BinarySource>(path, std::move(text));
  return std::make_unique<FormattedSource>(path, std::move(text));
}

// Calls with each matrix of the file; entries of those that begin() wants.
void visit(const std::filesystem::path& path, const Begin& begin, const Take& take) {
  const std::unique_ptr<Source> source = open_op4(path);
  Op4Head head;
  std::int64_t rows = 0;
  int type = 0;
  std::vector<double> values;
  while (source->head(head.name, rows, head.columns, type)) {
    std::erase_if(head.name, [](unsigned char c) { return std::isspace(c) != 0 || c == '\0'; });
    std::ranges::transform(head.name, head.name.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    head.rows = std::abs(rows);
    if (head.rows < 1 || head.columns < 1 || head.rows > kMostRows || head.columns > kMostRows)
      source->fail(
          fmt::format("matrix \"{}\" has {} rows and {} columns", head.name, head.rows, head.columns));
    const bool wanted = begin(head);
    if (type != 1 && type != 2)
      source->fail(
          fmt::format("matrix \"{}\" is of type {}, complex; 1 or 2 (real) is taken", head.name, type));
    const bool big = rows < 0 || rows >= kBigMat;
    const auto put = [&](std::int64_t column, std::int64_t row, std::int64_t count) {
      source->numbers(count, values);
      if (row < 1 || row - 1 + count > head.rows)
        source->fail(fmt::format("column {} of matrix \"{}\" goes from row {} to {}, and there are {}",
                                 column, head.name, row, row - 1 + count, head.rows));
      if (!wanted) return;
      for (std::int64_t k = 0; k < count; ++k)
        take(row - 1 + k, column - 1, values[static_cast<std::size_t>(k)]);
    };
    for (;;) {
      const auto [column, row, n_words] = source->column();
      if (column < 1 || column > head.columns + 1)
        source->fail(
            fmt::format("matrix \"{}\" has a column {}, and there are {}", head.name, column, head.columns));
      if (column > head.columns) {  // one number ends the matrix
        source->numbers(1, values);
        source->end();
        break;
      }
      if (row > 0) {
        put(column, row, n_words / source->words_in_columns());
        continue;
      }
      for (std::int64_t left = n_words; left > 0;) {
        std::int64_t length = 0, first = 0;
        if (big) {
          const auto [words, at] = source->big_string();
          length = words - 1, first = at;
          left -= length + 2;
        } else {
          const std::int64_t word = source->small_string();
          length = (word >> 16) - 1, first = word - ((length + 1) << 16);
          left -= length + 1;
        }
        if (length < 1)
          source->fail(fmt::format("column {} of matrix \"{}\" has an empty string", column, head.name));
        put(column, first, length / source->words_in_strings());
      }
    }
  }
}

}  // namespace

bool is_op4(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".op4";
}

void read_op4(const std::filesystem::path& path, char letter,
              const std::function<void(const Op4Head&)>& begin, const Take& take) {
  std::vector<std::string> names;
  visit(path,
        [&](const Op4Head& head) {
          names.push_back(head.name);
          return false;
        },
        {});
  if (names.empty()) refuse(path, "holds no matrix; write K and M into it");
  std::vector<std::string> fit;
  for (const std::string& name : names)
    if (names.size() == 1 || (name.starts_with(letter) && !name.starts_with("K4"))) fit.push_back(name);
  if (fit.size() != 1)
    refuse(
        path,
        fmt::format("{} of its matrices ({}) {}, one is wanted; put the one that is meant into a file of its "
                    "own",
                    fit.size(), fmt::join(names, ", "),
                    letter == '\0' ? "could be meant" : fmt::format("begin with {}", letter)));
  visit(
      path,
      [&](const Op4Head& head) {
        const bool wanted = head.name == fit.front();
        if (wanted) begin(head);
        return wanted;
      },
      take);
}

}  // namespace flexura::reduce
