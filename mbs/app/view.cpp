// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/results/results.hpp"
#include "mbs/terminal/terminal.hpp"
#include "mbs/view/pages.hpp"

namespace flexura::app {
namespace {

struct Arguments {
  std::string file, html;
  std::vector<std::string> plots;
  int frames = view::MotionPage{}.most_frames;
  bool summary = false;
};

using Lines = std::vector<std::pair<std::string, std::string>>;

/// The numbers and words of a run's summary, "energy.error" for a number inside a table; lists are left to
/// the page, and so are the estimated errors of the single outputs.
void flatten(const nlohmann::json& value, const std::string& name, Lines& lines) {
  if (name == "estimate.outputs") return;
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

/// How the runs ended, side by side, then the range of every quantity.
std::string summary_text(const results::Results& results, int width, bool colour) {
  std::vector<terminal::Column> columns = {{"", terminal::Align::left}};
  for (const auto& run : results.runs) columns.push_back({run.name, terminal::Align::right});
  terminal::Table table(columns);
  std::vector<std::string> names;
  std::map<std::string, std::vector<std::string>> cells;
  std::vector<std::string> warnings;
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
    const auto summary = nlohmann::json::parse(run.summary_json, nullptr, false);
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
    for (auto& [name, text] : lines) put(i, name, std::move(text));
    for (std::size_t j = 0; j < run.quantities.size() && run.time.size() > 0; ++j) {
      const auto values = run.values.col(static_cast<Eigen::Index>(j));
      put(i, fmt::format("{} [{}]", run.quantities[j].name, run.quantities[j].unit),
          fmt::format("{} .. {}", terminal::number(values.minCoeff(), 4),
                      terminal::number(values.maxCoeff(), 4)));
    }
  }
  for (const std::string& name : names) {
    std::vector<std::string> row = {name};
    row.insert(row.end(), cells[name].begin(), cells[name].end());
    table.add_row(std::move(row));
  }
  std::string text =
      fmt::format("{}\n{}", terminal::bold(results.model.name, colour), table.text(width, colour));
  for (const std::string& warning : warnings) text += "warning: " + warning + "\n";
  return text;
}

int run(const Arguments& arguments, const terminal::Talk& talk) {
  if (arguments.frames < 2)
    throw std::invalid_argument(fmt::format("--frames is {}, it must be at least 2", arguments.frames));
  terminal::require_folder_of(arguments.html);
  const results::Results results = results::read(arguments.file);
  if (arguments.summary) {
    fmt::print("{}", summary_text(results, terminal::width(stdout), terminal::takes_colour(stdout)));
    if (arguments.html.empty()) return 0;
  }
  const view::Pictures pictures = view::read_pictures(results.model, arguments.file);
  std::filesystem::path html = arguments.html;
  if (html.empty()) html = std::filesystem::path(arguments.file).replace_extension(".html");
  view::MotionPage page;
  page.plots = arguments.plots;
  page.most_frames = arguments.frames;
  view::write_motion_page(html, results, pictures, page);
  if (!talk.quiet) {
    fmt::print("wrote {} ({:.1f} MB): open it in a browser\n", html.string(),
               static_cast<double>(std::filesystem::file_size(html)) / 1e6);
  }
  return 0;
}

}  // namespace

terminal::Command view_command() {
  return {"view", "write a page on which a simulated mechanism moves, with plots of its quantities",
          [](terminal::Options& options, const terminal::Talk& talk) -> std::function<int()> {
            auto arguments = std::make_shared<Arguments>();
            options.argument("RESULTS", arguments->file, "results file; superelements lie where it says")
                .option("-o,--output", arguments->html, "PAGE", "the page (otherwise RESULTS with .html)")
                .option("--plot", arguments->plots, "NAME",
                        "plot this quantity at first; names joined by commas share a plot")
                .option("--frames", arguments->frames, "N", "keep at most this many poses of each run")
                .flag("--summary", arguments->summary,
                      "print how the runs ended and the range of each quantity; with -o also write the page")
                .example("flexura view engine.h5 -o engine.html", "look at it in a browser")
                .example("flexura view engine.h5 --plot crank.speed energy.kinetic,energy.strain",
                         "two plots, the second with two curves for each run");
            return [arguments, &talk] { return run(*arguments, talk); };
          }};
}

}  // namespace flexura::app
