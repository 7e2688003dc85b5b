// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/results/spectrum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "mbs/app/commands.hpp"
#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/units.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/files/table_text.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/results/results.hpp"

/// spectrum: amplitudes of stored quantities over frequency, with the orders of a speed.
namespace flexura::app {
namespace {

struct Arguments {
  std::string file, from, to, window = "hann", speed, run, output;
  std::vector<std::string> quantities;
  int count = 10;
  bool json = false;
};

double time_of(const std::string& text, double otherwise, const char* option) {
  if (text.empty()) return otherwise;
  try {
    return input::parse_quantity(text, input::dim::time);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{} {}: {}", option, text, error.what()));
  }
}

Eigen::Index place_of(const results::Run& run, const std::string& name, const std::string& file) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < run.quantities.size(); ++i) {
    if (run.quantities[i].name == name) return static_cast<Eigen::Index>(i);
    known.push_back(run.quantities[i].name);
  }
  throw std::invalid_argument(fmt::format("{}: run \"{}\" has no quantity \"{}\"{}", file, run.name, name,
                                          input::suggestion(name, known)));
}

// Turns per second, and how far they go from it.
struct Base {
  double frequency = 0.0, least = 0.0, most = 0.0;
};

Base base_of(const results::Run& run, const Arguments& a, double from, double to) {
  const Eigen::Index place = place_of(run, a.speed, a.file);
  if (const std::string& unit = run.quantities[static_cast<std::size_t>(place)].unit; unit != "rad/s")
    throw std::invalid_argument(
        fmt::format("--speed {}: is in \"{}\"; name an angular velocity, in rad/s", a.speed, unit));
  Base base;
  base.least = std::numeric_limits<double>::infinity();
  int n = 0;
  for (Eigen::Index i = 0; i < run.time.size(); ++i) {
    if (run.time(i) < from || run.time(i) > to) continue;
    const double f = std::abs(run.values(i, place)) / (2.0 * std::numbers::pi);
    base.frequency += f;
    base.least = std::min(base.least, f);
    base.most = std::max(base.most, f);
    ++n;
  }
  base.frequency /= std::max(1, n);
  if (!(base.frequency > 0.0))
    throw std::invalid_argument(fmt::format("--speed {}: is 0 in all rows; name one that turns", a.speed));
  return base;
}

struct Column {
  const results::Run* run;
  results::Quantity quantity;
  results::Spectrum spectrum;
  std::optional<Base> base;
};

// The half order that a line may belong to: as near as the resolution and the speed's own range leave it open.
std::string order_mark(const Column& column, double frequency) {
  const double order = frequency / column.base->frequency, half = std::round(2.0 * order) / 2.0;
  const double open = (column.spectrum.resolution + half * (column.base->most - column.base->least) / 2.0) /
                      column.base->frequency;
  return half > 0.0 && std::abs(order - half) <= open && open < 0.25 ? fmt::format("{:g}", half) : "";
}

void write_table(const std::vector<Column>& columns, const std::filesystem::path& path) {
  std::string text;
  for (const Column& c : columns)
    text +=
        fmt::format("{}{},{}", text.empty() ? "" : ",", files::csv_field(c.run->name + ": frequency [Hz]"),
                    files::csv_field(c.run->name + ": " + c.quantity.name + " [" + c.quantity.unit + "]"));
  text += '\n';
  Eigen::Index most = 0;
  for (const Column& c : columns) most = std::max(most, c.spectrum.frequency.size());
  for (Eigen::Index k = 0; k < most; ++k) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i > 0) text += ',';
      const results::Spectrum& s = columns[i].spectrum;
      text += k < s.frequency.size() ? fmt::format("{},{}", s.frequency(k), s.amplitude(k)) : ",";
    }
    text += '\n';
  }
  files::write_whole(path, text);
}

int compute(const Arguments& a, const terminal::Verbosity& verbosity) {
  if (a.count < 1) throw std::invalid_argument(fmt::format("--count is {}, it must be at least 1", a.count));
  const double infinite = std::numeric_limits<double>::infinity(),
               from = time_of(a.from, -infinite, "--from"), to = time_of(a.to, infinite, "--to");
  if (!(from < to)) throw std::invalid_argument(fmt::format("--to {}: is not after --from {}", a.to, a.from));
  files::Claims claims;
  if (!a.output.empty()) claims.add(a.output);
  const auto window = a.window == "none"   ? results::Window::none
                      : a.window == "hann" ? results::Window::hann
                                           : results::Window::flat_top;
  const results::Results file = results::read(a.file);
  std::vector<Column> columns;
  std::vector<std::string> runs;
  std::string left_out;
  for (const results::Run& run : file.runs) {
    runs.push_back(run.name);
    if (!a.run.empty() && run.name != a.run) continue;
    for (const std::string& name : a.quantities) {
      const Eigen::Index place = place_of(run, name, a.file);
      Column column{&run, run.quantities[static_cast<std::size_t>(place)], {}, {}};
      try {
        column.spectrum = results::amplitude_spectrum(run.time, run.values.col(place), from, to, window);
      } catch (const std::invalid_argument& error) {
        const std::string why = fmt::format("{}: run \"{}\": {}", a.file, run.name, error.what());
        if (!a.run.empty() || file.runs.size() == 1) throw std::invalid_argument(why);
        left_out = why;
        continue;
      }
      if (!a.speed.empty()) column.base = base_of(run, a, from, to);
      columns.push_back(std::move(column));
    }
  }
  if (columns.empty() && !left_out.empty()) throw std::invalid_argument(left_out);
  if (columns.empty())
    throw std::invalid_argument(
        fmt::format("{}: there is no run \"{}\"{}", a.file, a.run, input::suggestion(a.run, runs)));
  if (!left_out.empty()) terminal::say(stderr, "note: " + left_out + "; it is left out");
  if (!a.output.empty()) write_table(columns, a.output);
  nlohmann::json told = nlohmann::json::array();
  for (const Column& c : columns) {
    const results::Spectrum& s = c.spectrum;
    nlohmann::json lines = nlohmann::json::array();
    std::vector<terminal::Column> heads = {{"frequency [Hz]"}, {"amplitude [" + c.quantity.unit + "]"}};
    if (c.base) heads.insert(heads.end(), {{"order"}, {"of the speed"}});
    terminal::Table table(heads);
    for (const Eigen::Index k : results::peaks(s, window, a.count)) {
      std::vector<std::string> cells = {terminal::number(s.frequency(k), 6),
                                        terminal::number(s.amplitude(k), 4)};
      lines.push_back({{"frequency_hz", s.frequency(k)}, {"amplitude", s.amplitude(k)}});
      if (c.base) {
        // Of a speed that goes from nothing to twice its mean no order means anything.
        const bool is_steady = c.base->most - c.base->least < 0.5 * c.base->frequency;
        cells.push_back(is_steady ? terminal::number(s.frequency(k) / c.base->frequency, 4) : "?");
        cells.push_back(order_mark(c, s.frequency(k)));
        lines.back()["order"] =
            is_steady ? nlohmann::json(s.frequency(k) / c.base->frequency) : nlohmann::json();
      }
      table.add_row(cells);
    }
    told.push_back({{"run", c.run->name},
                    {"quantity", c.quantity.name},
                    {"unit", c.quantity.unit},
                    {"window", a.window},
                    {"mean", s.mean},
                    {"resolution_hz", s.resolution},
                    {"peaks", lines}});
    if (c.base) told.back()["speed_hz"] = c.base->frequency;
    if (a.json || verbosity.quiet) continue;
    fmt::print("{}, run {}: mean {} {}, lines {} Hz apart up to {} Hz\n\n", c.quantity.name, c.run->name,
               terminal::number(s.mean, 5), c.quantity.unit, terminal::number(s.resolution, 4),
               terminal::number(s.frequency(s.frequency.size() - 1), 5));
    fmt::print("{}\n", table.text(terminal::width(stdout), terminal::takes_colour(stdout)));
    if (s.resampled) terminal::say(stdout, "note: rows are not equidistant: taken as linear between them");
    if (c.base)
      terminal::say(stdout,
                    fmt::format("note: \"{}\" turns {} times a second on the average, {} to {}", a.speed,
                                terminal::number(c.base->frequency, 5), terminal::number(c.base->least, 5),
                                terminal::number(c.base->most, 5)));
  }
  if (a.json) fmt::print("{}\n", nlohmann::json{{"spectra", told}}.dump(1));
  if (!a.json && !verbosity.quiet && !a.output.empty()) fmt::print("table {}\n", a.output);
  return 0;
}

}  // namespace

terminal::Command spectrum_command() {
  return {"spectrum", "amplitudes of stored quantities over frequency, and the orders of a speed",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto a = std::make_shared<Arguments>();
            options.argument("RESULTS", a->file, "results file")
                .option("--quantity", a->quantities, "NAME", "whose spectrum")
                .required()
                .option("--run", a->run, "NAME", "this run only")
                .option("--from", a->from, "TIME", "from this time on, as in \"0.3 s\"")
                .option("--to", a->to, "TIME", "up to this time")
                .choice("--window", a->window, {"hann", "flat_top", "none"},
                        "hann; flat_top for amplitudes between lines; none for whole periods")
                .option("--speed", a->speed, "NAME", "stored angular velocity whose orders are marked")
                .option("-n,--count", a->count, "N", "as many of the largest lines are printed")
                .option("-o,--output", a->output, "FILE", "write all lines there, as CSV")
                .flag("--json", a->json, "print JSON")
                .example(
                    "flexura spectrum run_up.h5 --quantity teeth.force --speed drive.speed --from \"1 s\"",
                    "which engine orders the teeth hear");
            return [a, &verbosity] { return compute(*a, verbosity); };
          }};
}

}  // namespace flexura::app
