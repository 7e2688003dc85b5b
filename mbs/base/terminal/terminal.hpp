// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdio>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// What the programs print: tables that fit an 80-column terminal, a progress line with the time left, colour
/// where a person looks and none in a pipe.
namespace flexura::terminal {

/// The stream is a terminal that takes colour: not a file or pipe, TERM is not "dumb", NO_COLOR is not set.
bool takes_colour(std::FILE* stream);

/// Columns of the terminal behind the stream; $COLUMNS, or 80, when there is none.
int width(std::FILE* stream);

/// A sentence on lines of at most `width` columns, cut at blanks; lines after the first begin with `indent` of them.
std::string folded(const std::string& sentence, int width, int indent = 4);

/// Columns for sentences: those of a terminal, or $COLUMNS; without either (a pipe, a file) no bound, so that scripts find a
/// sentence on one line.
int takes_columns(std::FILE* stream);

/// Prints a note, a warning or an error with a line's end, folded to takes_columns().
void say(std::FILE* stream, const std::string& sentence);

/// The number of columns a UTF-8 text takes (one for each code point).
int display_width(std::string_view text);

/// `digits` significant digits, as short as they go: 1234.6, 0.00123, 2.1e+11.
std::string number(double value, int digits = 5);
/// "0.4 s", "12 s", "3 min 05 s", "2 h 10 min"
std::string duration(double seconds);
/// "812 B", "3.1 MB"
std::string bytes(double count);

/// Bold, dim or coloured text, plain when `colour` is false.
std::string bold(std::string_view text, bool colour);
std::string red(std::string_view text, bool colour);

enum class Align { left, right };

struct Column {
  std::string heading;
  Align align = Align::right;
};

/// A plain table: headings, a rule, rows.  Too wide for the given width, it shortens its widest left-aligned
/// columns, numbers never; where that is not enough it becomes several tables below one another, each of
/// which begins with the first `repeated` columns.
class Table {
 public:
  explicit Table(std::vector<Column> columns, std::size_t repeated = 1)
      : columns_(std::move(columns)), repeated_(repeated) {}
  void add_row(std::vector<std::string> cells);
  std::string text(int width = 80, bool colour = false) const;

 private:
  static int total(const std::vector<std::size_t>& columns, const std::vector<int>& widths);
  std::string block(const std::vector<std::size_t>& columns, const std::vector<int>& widths,
                    bool colour) const;

  std::vector<Column> columns_;
  std::size_t repeated_;
  std::vector<std::vector<std::string>> rows_;
};

/// One line that says how far a long task is, redrawn in place at most ten times a second:
///
///     meshing  [##########          ]  48 %  12 s, 13 s left
///
/// Where the stream is no terminal it says nothing; with `verbose` it then prints a line at the end of each
/// stage.
class Progress {
 public:
  using Clock = std::function<double()>;  ///< seconds

  explicit Progress(std::FILE* stream = stderr, bool quiet = false, bool verbose = false);
  /// For tests: what `is_terminal` and the time are.
  Progress(std::FILE* stream, bool quiet, bool is_terminal, Clock clock, bool verbose = false);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `fraction` of the stage done, 0 to 1; negative when nobody knows.
  void operator()(std::string_view stage, double fraction);
  /// Ends the last stage.
  void finish();
  /// Clears the line, so that something else can be printed.
  void clear();

 private:
  void end_stage();
  void draw(double fraction, double now);

  std::FILE* stream_;
  bool quiet_, draws_, drawn_ = false;
  Clock clock_;
  std::string stage_;
  double start_ = 0.0, last_drawn_ = -1.0;
};

}  // namespace flexura::terminal
