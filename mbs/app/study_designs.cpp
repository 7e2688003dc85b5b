// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/study_designs.hpp"

#include <fmt/format.h>

#include <cmath>

#include "mbs/base/terminal/terminal.hpp"
#include "mbs/view/reports/report.hpp"

namespace flexura::app {
namespace {

using terminal::number;

std::string heading(const std::string& label, const std::string& unit) {
  return unit.empty() ? label : label + " " + unit;
}

}  // namespace

void print_designs(const study::StudyFile& study, const study::Designs& designs) {
  const bool colour = terminal::takes_colour(stdout);
  std::vector<terminal::Column> columns = {{"choice", terminal::Align::left}, {"steps"}};
  for (std::size_t k = 0; k < study.quantities.size(); ++k) {
    columns.push_back({heading(study.quantities[k].label, designs.units[k])});
    columns.push_back({"known within"});
  }
  terminal::Table table(columns, 1);
  for (const study::DesignRow& row : designs.rows) {
    std::vector<std::string> cells = {row.choice->name, fmt::format("{}", row.cost->steps)};
    for (std::size_t k = 0; k < row.values.size(); ++k) {
      cells.push_back(std::isnan(row.values[k]) ? "failed" : number(row.values[k], 4));
      cells.push_back(std::isnan(row.uncertainty[k]) ? "unknown" : number(row.uncertainty[k], 2));
    }
    table.add_row(cells);
  }
  fmt::print("{}\n\n{}\n", terminal::bold(study.name, colour), table.text(terminal::width(stdout), colour));
  for (const std::string& text : designs.answers) fmt::print("{}\n", text);
  for (const std::string& text : designs.notes) terminal::say(stdout, "note: " + text);
}

void write_designs_page(const std::string& html, const study::StudyFile& study,
                        const study::Designs& designs) {
  view::Report report{.title = study.name + " · study",
                      .created_by = std::string("flexura ") + FLEXURA_VERSION};
  report.summary = "Designs compared: every choice run, and the values of its quantities.";
  report.facts = {{"choices", fmt::format("{}", designs.rows.size())},
                  {"mechanism", study.mechanism.filename().string()}};
  view::ReportSection& section = report.add("Designs");
  for (const std::string& answer : designs.answers) section.add(view::ReportText{answer});
  for (const std::string& note : designs.notes) section.add(view::ReportNotice{view::Tone::warning, note});
  view::ReportTable table{.title = "Choices",
                          .note = study.finer.empty()
                                      ? "How far the values are known is unknown: [want] has no finer."
                                      : "Values of the finer runs, and how far the others were from them.",
                          .columns = {{"choice"}, {"steps"}},
                          .rows = {}};
  for (std::size_t k = 0; k < study.quantities.size(); ++k) {
    table.columns.push_back({study.quantities[k].label, designs.units[k], 4});
    table.columns.push_back({"known within", designs.units[k], 2});
  }
  for (const study::DesignRow& row : designs.rows) {
    std::vector<view::ReportCell> line = {row.choice->name, static_cast<double>(row.cost->steps)};
    for (std::size_t k = 0; k < row.values.size(); ++k) {
      line.emplace_back(row.values[k]);
      line.emplace_back(row.uncertainty[k]);
    }
    table.rows.push_back(std::move(line));
  }
  section.add(std::move(table));
  view::write_report_page(html, report);
}

}  // namespace flexura::app
