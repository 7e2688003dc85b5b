// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mbs/view/reports/report.hpp"

namespace flexura::view {

namespace {

using nlohmann::json;

/// A value and where it stands: every refusal names the place.
class Reader {
 public:
  Reader(const json& value, std::string place) : value_(value), place_(std::move(place)) {}

  [[noreturn]] void fail(const std::string& expected) const {
    throw std::invalid_argument(
        fmt::format("the report's {} must be {}, not {}", place_, expected, value_.dump().substr(0, 60)));
  }
  bool is_object() const { return value_.is_object(); }
  const json& value() const { return value_; }

  bool has(const char* key) const { return value_.is_object() && value_.contains(key); }
  Reader at(const char* key) const {
    if (!value_.is_object()) fail("an object");
    if (!value_.contains(key)) fail(fmt::format("an object with \"{}\"", key));
    return {value_.at(key), fmt::format("{}.{}", place_, key)};
  }
  std::string text(const char* key) const { return has(key) ? at(key).text() : ""; }
  std::string text() const {
    if (!value_.is_string()) fail("text");
    return value_.get<std::string>();
  }
  double number() const {
    if (value_.is_null()) return std::numeric_limits<double>::quiet_NaN();
    if (!value_.is_number()) fail("a number or null");
    return value_.get<double>();
  }
  std::vector<Reader> list() const {
    if (!value_.is_array()) fail("a list");
    std::vector<Reader> items;
    for (std::size_t i = 0; i < value_.size(); ++i)
      items.push_back({value_[i], fmt::format("{}[{}]", place_, i)});
    return items;
  }
  std::vector<double> numbers() const {
    std::vector<double> values;
    for (const Reader& item : list()) values.push_back(item.number());
    return values;
  }
  std::vector<Fact> facts() const {
    std::vector<Fact> facts;
    for (const Reader& item : list()) {
      const auto pair = item.list();
      if (pair.size() != 2) item.fail("a pair of texts");
      facts.emplace_back(pair[0].text(), pair[1].text());
    }
    return facts;
  }
  Tone tone(Tone fallback) const {
    if (!has("tone")) return fallback;
    const std::string word = at("tone").text();
    if (word == "good") return Tone::good;
    if (word == "warning") return Tone::warning;
    if (word == "bad") return Tone::bad;
    if (word == "plain") return Tone::plain;
    at("tone").fail("\"good\", \"warning\", \"bad\" or \"plain\"");
  }

 private:
  const json& value_;
  std::string place_;
};

ReportCell read_cell(const Reader& cell) {
  if (!cell.is_object()) {
    if (cell.value().is_string()) return ReportCell(cell.text());
    return ReportCell(cell.number());
  }
  const Tone tone = cell.tone(Tone::plain);
  return cell.has("text") ? ReportCell(cell.text("text"), tone) : ReportCell(cell.at("value").number(), tone);
}

ReportTable read_table(const Reader& table) {
  ReportTable result{.title = table.text("title"), .note = table.text("note"), .columns = {}, .rows = {}};
  for (const Reader& column : table.at("columns").list()) {
    if (!column.is_object()) {
      result.columns.push_back({column.text()});
      continue;
    }
    ReportColumn line{column.at("name").text(), column.text("unit")};
    if (column.has("digits")) line.digits = static_cast<int>(column.at("digits").number());
    result.columns.push_back(line);
  }
  for (const Reader& row : table.at("rows").list()) {
    std::vector<ReportCell> cells;
    for (const Reader& cell : row.list()) cells.push_back(read_cell(cell));
    result.rows.push_back(std::move(cells));
  }
  return result;
}

ReportAxis read_axis(const Reader& axis) {
  return {axis.at("name").text(), axis.text("unit"),
          axis.has("logarithmic") && axis.at("logarithmic").value() == true};
}

ReportPlot read_plot(const Reader& plot) {
  ReportPlot result{.title = plot.at("title").text(),
                    .note = plot.text("note"),
                    .x = read_axis(plot.at("x")),
                    .y = read_axis(plot.at("y")),
                    .curves = {}};
  for (const Reader& curve : plot.at("curves").list()) {
    ReportCurve line{.name = curve.text("name"), .x = curve.at("x").numbers(), .y = curve.at("y").numbers()};
    const std::string style = curve.text("style");
    if (style == "points") {
      line.style = CurveStyle::points;
    } else if (style == "line and points") {
      line.style = CurveStyle::line_and_points;
    } else if (!style.empty() && style != "line") {
      curve.at("style").fail("\"line\", \"points\" or \"line and points\"");
    }
    if (curve.has("labels")) {
      for (const Reader& label : curve.at("labels").list()) line.labels.push_back(label.text());
    }
    result.curves.push_back(std::move(line));
  }
  return result;
}

ReportBlock read_block(const Reader& block) {
  if (block.has("text")) return ReportText{block.at("text").text()};
  if (block.has("notice")) return ReportNotice{block.tone(Tone::warning), block.at("notice").text()};
  if (block.has("facts")) return ReportFacts{block.at("facts").facts()};
  if (block.has("table")) return read_table(block.at("table"));
  if (block.has("plot")) return read_plot(block.at("plot"));
  if (block.has("code"))
    return ReportCode{block.at("code").text("title"), block.at("code").at("text").text()};
  block.fail("an object with one of \"text\", \"notice\", \"facts\", \"table\", \"plot\" and \"code\"");
}

}  // namespace

Report report_from_json(const json& value) {
  const Reader root(value, "JSON");
  Report report{.title = root.at("title").text(),
                .summary = root.text("summary"),
                .created_by = root.text("created_by")};
  if (root.has("facts")) report.facts = root.at("facts").facts();
  for (const Reader& section : root.at("sections").list()) {
    ReportSection& added = report.add(section.at("title").text());
    for (const Reader& block : section.at("blocks").list()) added.add(read_block(block));
  }
  return report;
}

}  // namespace flexura::view
