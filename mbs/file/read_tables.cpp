// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/read_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "mbs/base/documents/shown_text.hpp"
#include "mbs/formulas/formula_parser.hpp"

namespace flexura::mbs {
namespace {

struct Points {
  std::vector<double> x, y;
};

/// Two columns of numbers parted by blanks, commas or semicolons; # and lines without numbers are comments.
Points read_points(const input::Section& s) {
  const std::filesystem::path path = s.file("file");
  std::ifstream in(path);
  std::error_code ignored;
  if (in && !std::filesystem::is_regular_file(path, ignored))
    s.refuse("file", "is no file", "name the file itself");
  if (!in) s.refuse("file", "there is no such file", "paths start at the folder of this file");
  Points points;
  int row = 0;
  for (std::string line; std::getline(in, line);) {
    ++row;
    line = line.substr(0, line.find('#'));
    const auto refuse = [&](const std::string& why, const std::string& remedy) {
      s.refuse("file", fmt::format("line {} {}", row, why), remedy);
    };
    const auto first = line.find_first_not_of(" \t\r,;");
    const bool is_number = first != std::string::npos &&
                           std::string_view("+-.0123456789").find(line[first]) != std::string_view::npos;
    if (is_number && line.find(';') != std::string::npos && line.find(',') != std::string::npos)
      refuse("has a comma within its numbers", "the decimal sign is a point, like 0.5");
    for (char& c : line)
      if (c == ',' || c == ';' || c == '\t') c = ' ';
    if (line.find_first_not_of(" \r") == std::string::npos) continue;
    std::istringstream numbers(line);
    double x, y;
    if (!(numbers >> x >> y)) {
      if (points.x.empty() && !is_number) continue;  // a heading
      refuse("does not hold two numbers", "write one point on each line");
    }
    if (std::string more; numbers >> more)
      refuse(fmt::format("holds more than two numbers (\"{}\")", input::shown_text(more)),
             "write one point on each line, with a point as the decimal sign");
    points.x.push_back(x * s.quantity("x_unit"));
    points.y.push_back(y * s.quantity("y_unit"));
  }
  return points;
}

}  // namespace

input::TableSchema table_schema() {
  using namespace input;
  TableSchema schema;
  schema.name = "table";
  schema.doc =
      "A curve through points. Formulas call it by its name, as in drive = \"lift(360*t)\"; springs and "
      "bushings take it as their law. All in SI.";
  schema.keys = {
      quantities("x", dim::none, "rising"),
      quantities("y", dim::none, "as many"),
      text("file", "instead of x and y: a text file with two columns, beside this one"),
      quantity("x_unit", dim::none, "factor from the file's first column to SI").or_default("1"),
      quantity("y_unit", dim::none, "factor from the second").or_default("1"),
      choice("interpolation", {"linear", "cubic", "akima"},
             "cubic: natural spline, twice differentiable, as drives want it; akima: once, without overshoot")
          .or_default("cubic"),
      choice("outside", {"hold", "extend", "repeat"},
             "beyond the points: keep the end value, go on straight, or repeat the curve")
          .or_default("hold")};
  return schema;
}

Curves read_tables(const input::Section& root) {
  Curves tables;
  std::vector<std::string> meant =
      function_names();  // formulas would call these, or read them, and never the table
  meant.insert(meant.end(), {"t", "pi", "e"});
  for (const auto& [name, s] : root.table_map("table")) {
    if (std::ranges::find(meant, name) != meant.end())
      s.refuse("", fmt::format("\"{}\" has a meaning of its own in formulas", name), "choose another name");
    if (s.has("file") && (s.has("x") || s.has("y")))
      s.refuse("file", "stands beside x or y", "keep one of them");
    Points points{s.quantities("x"), s.quantities("y")};
    if (s.has("file")) points = read_points(s);
    const std::string kind = s.text("interpolation"), beyond = s.text("outside");
    try {
      tables[name] = std::make_shared<Curve>(std::move(points.x), std::move(points.y),
                                             kind == "linear"  ? Curve::Interpolation::linear
                                             : kind == "akima" ? Curve::Interpolation::akima
                                                               : Curve::Interpolation::cubic,
                                             beyond == "hold"     ? Curve::Outside::hold
                                             : beyond == "extend" ? Curve::Outside::extend
                                                                  : Curve::Outside::repeat);
    } catch (const std::invalid_argument& error) {
      s.refuse("", error.what());
    }
  }
  return tables;
}

}  // namespace flexura::mbs
