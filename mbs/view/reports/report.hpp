// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

/// Report pages: one HTML file of sections with text, facts, tables and plots, for a reduction, a study or
/// the tables of the tests at the extremes.  The page stands without a script (tables are HTML, plots are
/// SVG), so it prints and is read by screen readers; its small script adds the switch between light and dark,
/// sorting, the values under the pointer and CSV.
///
///     Report report{.title = "steam engine · study", .created_by = "flexura 0.1.0"};
///     report.facts = {{"runs", "24"}, {"wall time", "3 min 05 s"}};
///     ReportSection& section = report.add("Speed against accuracy");
///     section.add(ReportText{"Each point is one run ..."});
///     section.add(ReportPlot{.title = "Error over wall time", .x = {"wall time", "s", true},
///                            .y = {"error", "1", true}, .curves = {{"IDA", times, errors}}});
///     section.add(ReportTable{.columns = {{"run"}, {"wall time", "s"}, {"error"}},
///                             .rows = {{"modal", 0.31, 2.0e-4}, {"rigid", 0.02, {1.0e-1, Tone::bad}}}});
///     write_report_page("study.html", report);
namespace flexura::view {

/// What a notice or a cell says besides its text; it is never said by colour alone.
enum class Tone { plain, good, warning, bad };

/// A name and what it stands for: "mass", "2.276 kg".
using Fact = std::pair<std::string, std::string>;

struct ReportText {
  std::string text;  ///< paragraphs, apart by an empty line
};

struct ReportNotice {
  Tone tone = Tone::warning;
  std::string text;
};

struct ReportFacts {
  std::vector<Fact> facts;
};

/// Text, or a number that is printed with its column's digits and sorted by its value.
struct ReportCell {
  ReportCell(std::string words, Tone how = Tone::plain) : text(std::move(words)), tone(how) {}
  ReportCell(const char* words, Tone how = Tone::plain) : text(words), tone(how) {}
  ReportCell(double number, Tone how = Tone::plain) : value(number), is_number(true), tone(how) {}
  ReportCell(int number, Tone how = Tone::plain) : value(number), is_number(true), tone(how) {}

  std::string text;
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN is printed as a dash
  bool is_number = false;
  Tone tone = Tone::plain;
};

struct ReportColumn {
  std::string name;
  std::string unit{};  ///< SI, "kg*m^2"; "" without one
  int digits = 5;      ///< significant digits of numbers
};

struct ReportTable {
  std::string title{}, note{};
  std::vector<ReportColumn> columns;
  std::vector<std::vector<ReportCell>> rows;
};

enum class CurveStyle { line, points, line_and_points };

struct ReportCurve {
  std::string name;
  std::vector<double> x, y;  ///< of equal length; values that are not finite leave a gap
  CurveStyle style = CurveStyle::line;
  std::vector<std::string> labels{};  ///< one for each point, or none
};

struct ReportAxis {
  std::string name;
  std::string unit{};
  bool logarithmic = false;  ///< values that are not positive are left out
};

struct ReportPlot {
  std::string title, note{};
  ReportAxis x, y;
  std::vector<ReportCurve> curves;
};

/// Text kept as it is, in a fixed-width face: an input file, a command.
struct ReportCode {
  std::string title, text;
};

/// A drawing, an SVG element that the program made (part_drawing.hpp), never a user's text.
struct ReportDrawing {
  std::string title, svg, note{};
};

using ReportBlock =
    std::variant<ReportText, ReportNotice, ReportFacts, ReportTable, ReportPlot, ReportCode, ReportDrawing>;

struct ReportSection {
  std::string title;
  std::vector<ReportBlock> blocks{};

  ReportSection& add(ReportBlock block) {
    blocks.push_back(std::move(block));
    return *this;
  }
};

struct Report {
  std::string title;         ///< "conrod · reduction"
  std::string summary{};     ///< one sentence under the title
  std::string created_by{};  ///< program and version
  std::vector<Fact> facts{};
  std::vector<ReportSection> sections{};

  /// The reference holds until the next section is added.
  ReportSection& add(std::string heading) {
    sections.push_back({std::move(heading), {}});
    return sections.back();
  }
};

/// Writes the page (beside as FILE.part, then renamed).  Throws std::invalid_argument, naming section and
/// block, when a row has not as many cells as the table columns or a curve's x, y and labels differ in
/// length, and std::runtime_error when the file cannot be written.
void write_report_page(const std::filesystem::path& html, const Report& report);

/// The same structure as JSON, for programs and scripts that are not linked with this library
/// (`flexura report FILE.json`):
///
///     {"title", "summary", "created_by", "facts": [["name", "value"], ...],
///      "sections": [{"title", "blocks": [
///        {"text": "..."}, {"notice": "...", "tone": "good" | "warning" | "bad"}, {"facts": [[...]]},
///        {"table": {"title", "note", "columns": ["name" | {"name", "unit", "digits"}],
///                   "rows": [[cell, ...]]}},
///        {"code": {"title", "text"}},
///        {"plot": {"title", "note", "x": axis, "y": axis,
///                  "curves": [{"name", "x", "y", "style", "labels"}]}}]}]}
///
/// axis: {"name", "unit", "logarithmic"}; style: "line", "points", "line and points"; cell: text, number, null or
/// {"text" | "value", "tone"}.  Only title and sections must be there.  Throws std::invalid_argument, naming
/// the place and what is expected there.
Report report_from_json(const nlohmann::json& json);

}  // namespace flexura::view
