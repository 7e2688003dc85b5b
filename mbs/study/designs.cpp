// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/designs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "mbs/base/files/table_text.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/results/results.hpp"
#include "mbs/study/judge.hpp"

namespace flexura::study {
namespace {

using files::markdown_text;
using nlohmann::json;
using terminal::number;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::vector<double> values_of(const StudyFile& study, const Measurement& m, std::vector<std::string>* units) {
  if (!m.complete) return std::vector<double>(study.quantities.size(), kUnknown);
  const results::Run run = std::move(results::read(m.results).runs.front());
  const std::vector<Signal> signals = read_signals(study, run);
  std::vector<double> values;
  for (std::size_t k = 0; k < signals.size(); ++k) {
    const WantedQuantity& q = study.quantities[k];
    values.push_back(value_of(signals[k], q.norm));
    const auto stored = std::ranges::find(run.quantities, q.name, &results::Quantity::name);
    if (units) (*units)[k] = q.norm == Norm::count ? "" : q.norm == Norm::frequency ? "Hz" : stored->unit;
  }
  return values;
}

std::string with_unit(double value, const std::string& unit) {
  return number(value, 4) + (unit.empty() ? "" : " " + unit);
}

std::string answer(const StudyFile& study, const Designs& designs, const Goal& goal) {
  const std::size_t k = goal.quantity;
  const std::string label = (goal.is_least ? "least " : "greatest ") + study.quantities[k].label;
  const DesignRow* best = nullptr;
  const auto is_better = [&](double a, double b) { return goal.is_least ? a < b : a > b; };
  for (const DesignRow& row : designs.rows)
    if (!std::isnan(row.values[k]) && (!best || is_better(row.values[k], best->values[k]))) best = &row;
  if (!best) return label + ": none of these choices ran through";
  std::string text = fmt::format(
      "{}: {} ({}, {})", label, best->choice->name, with_unit(best->values[k], designs.units[k]),
      std::isnan(best->uncertainty[k]) ? "how far it is known is unknown: give finer"
                                       : "known within " + with_unit(best->uncertainty[k], designs.units[k]));
  const auto add = [](std::string& names, const DesignRow& row) {
    names += (names.empty() ? "" : "; ") + row.choice->name;
  };
  std::string alike, unknown;
  for (const DesignRow& row : designs.rows) {
    if (&row == best || std::isnan(row.values[k])) continue;
    const double apart = std::abs(row.values[k] - best->values[k]);
    if (apart == 0.0 || apart <= row.uncertainty[k] + best->uncertainty[k])
      add(alike, row);
    else if (std::isnan(row.uncertainty[k]) && !std::isnan(best->uncertainty[k]))
      add(unknown, row);
  }
  if (!alike.empty()) text += "; within the uncertainty as good: " + alike;
  if (!unknown.empty()) text += "; perhaps better, how far they are known is unknown: " + unknown;
  return text;
}

json finite_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

}  // namespace

Designs compare_designs(const StudyFile& study, const Measurements& measured) {
  Designs out;
  out.units.assign(study.quantities.size(), "");
  for (std::size_t i = 0; i < study.choices.size(); ++i) {
    const Measurement& run = measured.choices[i];
    DesignRow row{&study.choices[i], &run, values_of(study, run, &out.units), {}};
    row.uncertainty.assign(row.values.size(), kUnknown);
    if (!run.complete)
      out.notes.push_back(fmt::format("{}: {}", row.choice->name, run.failure));
    else if (!study.finer.empty()) {
      const Measurement& again = measured.finer[i];
      const std::vector<double> finer = values_of(study, again, nullptr);
      if (again.complete) {
        for (std::size_t k = 0; k < finer.size(); ++k)
          row.uncertainty[k] = std::abs(row.values[k] - finer[k]);
        row.values = finer;
      } else {
        out.notes.push_back(fmt::format("{}: {}", study.finer[i].name, again.failure));
      }
    }
    out.rows.push_back(std::move(row));
  }
  for (const Goal& goal : study.goals) out.answers.push_back(answer(study, out, goal));
  return out;
}

json as_json(const StudyFile& study, const Designs& designs, const std::string& created_by) {
  json out = {{"name", study.name},
              {"created_by", created_by},
              {"mechanism", study.mechanism.string()},
              {"answers", designs.answers},
              {"notes", designs.notes}};
  for (std::size_t k = 0; k < study.quantities.size(); ++k)
    out["quantities"].push_back({{"label", study.quantities[k].label},
                                 {"of", study.quantities[k].name},
                                 {"norm", norm_names()[static_cast<std::size_t>(study.quantities[k].norm)]},
                                 {"unit", designs.units[k]}});
  for (const DesignRow& row : designs.rows) {
    json line = {{"name", row.choice->name},
                 {"set", row.choice->set},
                 {"part_set", row.choice->part_set},
                 {"results", std::filesystem::absolute(row.cost->results).string()},
                 {"complete", row.cost->complete},
                 {"steps", row.cost->steps},
                 {"failure", row.cost->failure}};
    for (std::size_t k = 0; k < row.values.size(); ++k) {
      line["values"].push_back(finite_or_null(row.values[k]));
      line["uncertainty"].push_back(finite_or_null(row.uncertainty[k]));
    }
    out["choices"].push_back(std::move(line));
  }
  return out;
}

std::string as_csv(const StudyFile& study, const Designs& designs) {
  std::string text = "choice,steps";
  for (std::size_t k = 0; k < study.quantities.size(); ++k) {
    const std::string head =
        study.quantities[k].label + (designs.units[k].empty() ? "" : " [" + designs.units[k] + "]");
    text += "," + files::csv_quoted(head) + "," + files::csv_quoted("uncertainty of " + head);
  }
  text += "\n";
  for (const DesignRow& row : designs.rows) {
    text += fmt::format("{},{}", files::csv_quoted(row.choice->name), row.cost->steps);
    for (std::size_t k = 0; k < row.values.size(); ++k)  // what is unknown is left empty
      for (const double value : {row.values[k], row.uncertainty[k]})
        text += std::isnan(value) ? "," : fmt::format(",{:.9g}", value);
    text += "\n";
  }
  return text;
}

std::string as_markdown(const StudyFile& study, const Designs& designs) {
  std::string text = fmt::format("## {}\n\n| choice |", markdown_text(study.name)), line = "|---|";
  for (std::size_t k = 0; k < study.quantities.size(); ++k) {
    text += fmt::format(" {}{} | known within |", markdown_text(study.quantities[k].label),
                        designs.units[k].empty() ? "" : " \\[" + markdown_text(designs.units[k]) + "\\]");
    line += "---|---|";
  }
  text += "\n" + line + "\n";
  for (const DesignRow& row : designs.rows) {
    text += fmt::format("| {} |", markdown_text(row.choice->name));
    for (std::size_t k = 0; k < row.values.size(); ++k)
      text += fmt::format(" {} | {} |", std::isnan(row.values[k]) ? "failed" : number(row.values[k], 4),
                          std::isnan(row.uncertainty[k]) ? "unknown" : number(row.uncertainty[k], 2));
    text += "\n";
  }
  text += "\n";
  for (const std::string& words : designs.answers) text += "- " + markdown_text(words) + "\n";
  for (const std::string& words : designs.notes) text += "- " + markdown_text(words) + "\n";
  return text;
}

}  // namespace flexura::study
