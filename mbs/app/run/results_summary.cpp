// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/results_summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "mbs/base/files/json_text.hpp"
#include "mbs/base/terminal/terminal.hpp"

namespace flexura::app {
namespace {

using Lines = std::vector<std::pair<std::string, std::string>>;

/// The numbers and words of a run's summary, "energy.error" for a number inside a table; lists are left to
/// the page, and so are the estimated errors of the single outputs and what was left out of each body.
void flatten(const nlohmann::json& value, const std::string& name, Lines& lines) {
  if (name == "estimate.outputs" || name == "left_out.bodies") return;
  if (value.is_object()) {
    for (const auto& [key, inner] : value.items())
      flatten(inner, name.empty() ? key : name + "." + key, lines);
  } else if (value.is_number()) {
    lines.emplace_back(name, terminal::number(value.get<double>()));
  } else if (value.is_string()) {
    lines.emplace_back(name, value.get<std::string>());
  } else if (value.is_boolean()) {
    lines.emplace_back(name, value.get<bool>() ? "yes" : "no");
  }
}

/// What the program's own summaries hold, in the words and the order in which it is read.
constexpr std::array kWords = {
    std::pair{"relative_energy_error", "relative energy error"},
    std::pair{"energy_error", "energy balance, end [J]"},
    std::pair{"largest_energy_error", "largest energy imbalance [J]"},
    std::pair{"work_in", "work done on it [J]"},
    std::pair{"dissipated", "energy dissipated [J]"},
    std::pair{"estimate.at_least", "estimated error, at least"},
    std::pair{"peak_position_drift", "largest drift of positions"},
    std::pair{"peak_velocity_drift", "largest drift of velocities"},
    std::pair{"method", "integrator"},
    std::pair{"tolerance", "tolerance"},
    std::pair{"steps", "steps"},
    std::pair{"switches", "switches"},
    std::pair{"redundant_constraints", "redundant constraints"},
    std::pair{"wall_time", "computing time [s]"},
    std::pair{"real_time_factor", "computing / simulated time"},
};

/// "2.1 %" of a share.
std::string per_cent(const std::string& share) {
  return terminal::number(100.0 * std::strtod(share.c_str(), nullptr), 3) + " %";
}

/// In their order, then the others; what says nothing (an empty word), stands above already or is a detail of the estimated
/// error (which the run prints in words, and --json holds) is left out.
Lines in_words(const Lines& lines) {
  Lines out;
  const auto named = [](const std::string& name) {
    return std::ranges::find_if(kWords, [&](const auto& word) { return name == word.first; });
  };
  // Null, hence no line, where a part of it is unknown: what nothing but unknown parts make is no "at least 0".
  const bool is_whole =
      std::ranges::any_of(lines, [](const auto& line) { return line.first == "estimate.error"; });
  const auto estimated = [&](const std::string& text) {
    return is_whole || std::strtod(text.c_str(), nullptr) > 0.0 ? per_cent(text) : std::string("unknown");
  };
  for (const auto& [key, words] : kWords)
    for (const auto& [name, text] : lines)
      if (name == key) out.emplace_back(words, name == "estimate.at_least" ? estimated(text) : text);
  for (const auto& [name, text] : lines) {
    if (text.empty() || name == "end_time" || name.starts_with("left_out.") ||
        name.starts_with("estimate.") || named(name) != kWords.end())
      continue;
    std::string shown = name;
    std::ranges::replace(shown, '_', ' ');
    out.emplace_back(shown, text);
  }
  return out;
}

/// The largest size of the run's quantities in each unit; a torque of 1e-14 N m beside 30 J is round-off.
std::map<std::string, double> scales_of(const results::Run& run) {
  std::map<std::string, double> scales;
  for (std::size_t j = 0; j < run.quantities.size() && run.time.size() > 0; ++j) {
    double& scale = scales[run.quantities[j].unit == "J" ? "N*m" : run.quantities[j].unit];
    const double size = run.values.col(static_cast<Eigen::Index>(j)).cwiseAbs().maxCoeff();
    if (std::isfinite(size)) scale = std::max(scale, size);
  }
  return scales;
}

/// "-2.26 .. 2.25"; what is round-off beside the other end, or beside the other quantities of its unit, is 0.
std::string range_text(double low, double high, double scale) {
  const double least = std::max(1e-13 * std::max(std::abs(low), std::abs(high)), 1e-14 * scale);
  const auto text = [&](double x) { return terminal::number(std::abs(x) < least ? 0.0 : x, 4); };
  return fmt::format("{} .. {}", text(low), text(high));
}

/// "2.3e+07 Pa at t = 0.12 s, at (0.1, 0, 0.02) m" of the largest value of a quantity NAME.von_mises; where
/// it was only if NAME.von_mises_x, _y and _z are stored.
std::string peak_of(const results::Run& run, std::size_t j) {
  Eigen::Index row = 0;
  const double largest = run.values.col(static_cast<Eigen::Index>(j)).maxCoeff(&row);
  std::string text = fmt::format("{} {} at t = {} s", terminal::number(largest, 4), run.quantities[j].unit,
                                 terminal::number(run.time[row], 4));
  std::vector<std::string> at;
  for (const char* axis : {"_x", "_y", "_z"})
    for (std::size_t k = 0; k < run.quantities.size(); ++k)
      if (run.quantities[k].name == run.quantities[j].name + axis)
        at.push_back(terminal::number(run.values(row, static_cast<Eigen::Index>(k)), 4));
  if (at.size() == 3) text += fmt::format(", at ({}) m", fmt::join(at, ", "));
  return text;
}

}  // namespace

std::string summary_text(const results::Results& results, int width, bool colour) {
  std::vector<terminal::Column> columns = {{"", terminal::Align::left}};
  for (const auto& run : results.runs) columns.push_back({run.name, terminal::Align::right});
  terminal::Table table(columns);
  std::vector<std::string> names;
  std::map<std::string, std::vector<std::string>> cells;
  std::vector<std::string> warnings, peaks;
  const auto put = [&](std::size_t run, const std::string& name, std::string text) {
    auto [entry, is_new] = cells.try_emplace(name, results.runs.size());
    if (is_new) names.push_back(name);
    entry->second[run] = std::move(text);
  };
  for (std::size_t i = 0; i < results.runs.size(); ++i) {
    const results::Run& run = results.runs[i];
    put(i, "complete", run.complete ? "yes" : "no");
    if (!run.complete) warnings.push_back(fmt::format("{} stopped early: {}", run.name, run.stopped_because));
    if (run.time.size() > 0) put(i, "end time [s]", terminal::number(run.time[run.time.size() - 1]));
    put(i, "rows stored", fmt::format("{}", run.time.size()));
    const auto summary = files::try_read_json(run.summary_json);
    Lines lines;
    if (summary.is_object()) {
      flatten(summary, "", lines);
      const auto found = summary.find("warnings");
      if (found != summary.end() && found->is_array()) {
        for (const auto& text : *found) {
          if (text.is_string()) warnings.push_back(fmt::format("{}: {}", run.name, text.get<std::string>()));
        }
      }
    }
    const std::map<std::string, double> scales = scales_of(run);
    for (auto& [name, text] : in_words(lines)) put(i, name, std::move(text));
    for (std::size_t j = 0; j < run.quantities.size() && run.time.size() > 0; ++j) {
      const auto values = run.values.col(static_cast<Eigen::Index>(j));
      if (run.quantities[j].name.ends_with(".von_mises"))
        peaks.push_back(fmt::format("{}: largest {} {}", run.name, run.quantities[j].name, peak_of(run, j)));
      put(i,
          fmt::format("{} [{}]", run.quantities[j].name,
                      run.quantities[j].unit.empty() ? "-" : run.quantities[j].unit),
          range_text(values.minCoeff(), values.maxCoeff(),
                     run.quantities[j].unit.empty()
                         ? 0.0
                         : scales.at(run.quantities[j].unit == "J" ? "N*m" : run.quantities[j].unit)));
    }
  }
  for (const std::string& name : names) {
    std::vector<std::string> row = {name};
    row.insert(row.end(), cells[name].begin(), cells[name].end());
    table.add_row(std::move(row));
  }
  std::string text =
      fmt::format("{}\n{}", terminal::bold(results.model.name, colour), table.text(width, colour));
  for (const std::string& peak : peaks)
    text += terminal::folded(peak, terminal::takes_columns(stdout)) + "\n";
  for (const std::string& warning : warnings)
    text += terminal::folded("warning: " + warning, terminal::takes_columns(stdout)) + "\n";
  return text;
}

nlohmann::json summary_json(const std::string& kind, const results::Results& results) {
  using nlohmann::json;
  json runs = json::array();
  for (const results::Run& run : results.runs) {
    const Eigen::Index n_t = run.time.size();
    json quantities = json::array();
    for (std::size_t j = 0; j < run.quantities.size() && n_t > 0; ++j) {
      const auto values = run.values.col(static_cast<Eigen::Index>(j));
      quantities.push_back({{"name", run.quantities[j].name},
                            {"unit", run.quantities[j].unit},
                            {"smallest", values.minCoeff()},
                            {"largest", values.maxCoeff()}});
    }
    json summary = files::try_read_json(run.summary_json);
    if (summary.is_discarded()) summary = json::object();
    runs.push_back({{"run", run.name},
                    {"time_s", n_t > 0 ? json(run.time[n_t - 1]) : json()},
                    {"rows", n_t},
                    {"complete", run.complete},
                    {"stopped_because", run.stopped_because},
                    {"summary", std::move(summary)},
                    {"quantities", std::move(quantities)}});
  }
  return {{"kind", kind}, {"name", results.model.name}, {"runs", std::move(runs)}};
}

}  // namespace flexura::app
