// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/app/study_designs.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/files/place.hpp"
#include "mbs/base/files/signals.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/study/cache/child_process.hpp"
#include "mbs/study/front_picture.hpp"
#include "mbs/study/judge.hpp"
#include "mbs/study/tables.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/text_file.hpp"
#include "mbs/view/reports/report.hpp"

/// `flexura study`: the measured trade of speed against accuracy, as table, page, CSV, JSON and picture.
namespace flexura::app {
namespace {

using study::Judgement;
using study::Row;
using study::StudyFile;
using superelement::write_whole;
using terminal::Align;
using terminal::number;

struct Arguments {
  std::string file, output, share;
  std::vector<std::string> set;
  int jobs = 1;
  bool fresh = false, schema = false, json = false, run_scripts = false;
};

// A study's "2/4": the second of four shares.
void read_share(const std::string& text, study::MeasureOptions& options) {
  if (text.empty()) return;
  const char *end = text.data() + text.size(), *slash = text.data() + std::min(text.find('/'), text.size());
  const auto first = std::from_chars(text.data(), slash, options.share);
  const auto second = std::from_chars(std::min(slash + 1, end), end, options.shares);
  if (first.ptr != slash || second.ptr != end || slash == end || options.share < 1 ||
      options.share > options.shares)
    throw std::invalid_argument(fmt::format("--share {}: give I/N with 1 <= I <= N, like 2/4", text));
}

std::string percent(double fraction) {
  return number(100.0 * fraction, 3);
}

bool has_parts(const StudyFile& study) {
  return !study.parts.empty();
}
bool has_estimates(const Judgement& judgement) {
  return std::ranges::any_of(judgement.rows, [](const Row& r) { return r.estimate >= 0.0; });
}

void print_table(const StudyFile& study, const Judgement& judgement) {
  const bool colour = terminal::takes_colour(stdout), parts = has_parts(study),
             estimates = has_estimates(judgement);
  std::vector<terminal::Column> columns = {
      {"", Align::left}, {"choice", Align::left}, {"wall s"}, {"cpu s"}, {"memory"}, {"steps"},
      {"error %"},       {"to finest %"}};
  if (estimates) columns.push_back({"estimate %"});
  if (parts) columns.push_back({"reduce s"});
  terminal::Table table(columns, 2);
  for (const Row& row : judgement.rows) {
    const study::Measurement& c = *row.cost;
    std::vector<std::string> cells = {row.on_front ? "*" : "",
                                      row.choice->name,
                                      number(c.median_wall(), 3),
                                      number(c.median_cpu(), 3),
                                      terminal::bytes(c.peak_memory),
                                      fmt::format("{}", c.steps),
                                      percent(row.error.against_reference),
                                      percent(row.error.against_finest)};
    if (estimates)
      cells.push_back(row.estimate >= 0.0 ? (row.is_at_least ? ">= " : "") + percent(row.estimate) : "-");
    if (parts) cells.push_back(number(c.reduce_wall, 3));
    table.add_row(cells);
  }
  fmt::print("{}\n\n{}", terminal::bold(study.name, colour), table.text(terminal::width(stdout), colour));
  fmt::print("* = nothing else is both faster and more accurate; the reference is known within {} %\n\n",
             percent(judgement.largest_uncertainty));
  for (const std::string& text : judgement.answers) fmt::print("{}\n", text);
  for (const std::string& text : judgement.notes) terminal::say(stdout, "note: " + text);
}

view::ReportPlot front_plot(const StudyFile& study, const Judgement& judgement) {
  view::ReportPlot plot{
      .title = "Error over time",
      .note = fmt::format("The reference is known within {} %.", percent(judgement.largest_uncertainty)),
      .x = {study.cpu_is_cost ? "processor time" : "wall time", "s", true},
      .y = {"error", "%", true},
      .curves = {}};
  view::ReportCurve front{.name = "front", .x = {}, .y = {}, .style = view::CurveStyle::line_and_points};
  view::ReportCurve others{.name = "beaten", .x = {}, .y = {}, .style = view::CurveStyle::points};
  view::ReportCurve chosen{.name = "chosen", .x = {}, .y = {}, .style = view::CurveStyle::points};
  std::vector<const Row*> rows;
  for (const Row& row : judgement.rows) rows.push_back(&row);
  std::ranges::sort(rows, {}, &Row::price);
  for (const Row* row : rows) {
    view::ReportCurve& curve = row->choice->wanted > 0.0 ? chosen : row->on_front ? front : others;
    curve.x.push_back(row->price);
    curve.y.push_back(100.0 * row->error.against_reference);
    curve.labels.push_back(row->choice->name);
  }
  plot.curves = {std::move(front)};
  if (!others.x.empty()) plot.curves.push_back(std::move(others));
  if (!chosen.x.empty()) plot.curves.push_back(std::move(chosen));
  return plot;
}

view::Report report_of(const StudyFile& study, const Judgement& judgement) {
  view::Report report{.title = study.name + " · study",
                      .created_by = std::string("flexura ") + FLEXURA_VERSION};
  report.summary =
      "Speed against accuracy: every choice run, measured and compared with a converged reference.";
  report.facts = {{"choices", fmt::format("{}", judgement.rows.size())},
                  {"mechanism", study.mechanism.filename().string()},
                  {"reference known within", percent(judgement.largest_uncertainty) + " %"}};
  view::ReportSection& front = report.add("Speed against accuracy");
  for (const std::string& answer : judgement.answers) front.add(view::ReportText{answer});
  for (const std::string& note : judgement.notes) front.add(view::ReportNotice{view::Tone::warning, note});
  front.add(front_plot(study, judgement));
  view::ReportTable table{.title = "Choices",
                          .note = "Errors are relative, the largest of the quantities; times are medians.",
                          .columns = {{"choice"},
                                      {"front"},
                                      {"wall time", "s", 3},
                                      {"processor time", "s", 3},
                                      {"memory", "MB", 4},
                                      {"steps"},
                                      {"error", "%", 3},
                                      {"to the finest", "%", 3},
                                      {"estimated by the run", "%", 3},
                                      {"estimate over error", "", 2},
                                      {"reduction", "s", 3}},
                          .rows = {}};
  view::ReportTable errors{.title = "Errors of each quantity",
                           .note = "In per cent of the reference.",
                           .columns = {{"choice"}},
                           .rows = {}};
  for (const auto& q : study.quantities) errors.columns.push_back({q.label, "%", 3});
  for (const Row& row : judgement.rows) {
    const study::Measurement& c = *row.cost;
    table.rows.push_back({row.choice->name, row.on_front ? "front" : "", c.median_wall(), c.median_cpu(),
                          1e-6 * c.peak_memory, static_cast<double>(c.steps),
                          100.0 * row.error.against_reference, 100.0 * row.error.against_finest,
                          row.estimate >= 0.0 ? 100.0 * row.estimate : std::nan(""),
                          row.effectivity >= 0.0 ? row.effectivity : std::nan(""), c.reduce_wall});
    std::vector<view::ReportCell> line = {row.choice->name};
    for (const study::ErrorOf& e : row.errors) line.emplace_back(100.0 * e.against_reference);
    errors.rows.push_back(std::move(line));
  }
  if (!has_parts(study)) {  // nothing is reduced
    table.columns.pop_back();
    for (auto& line : table.rows) line.pop_back();
  }
  front.add(std::move(table)).add(std::move(errors));
  return report;
}

void tell_designs(const StudyFile& study, const study::Measurements& measured, const std::string& stem,
                  const Arguments& arguments, bool is_quiet) {
  const study::Designs designs = study::compare_designs(study, measured);
  const std::string json =
      study::as_json(study, designs, std::string("flexura ") + FLEXURA_VERSION).dump(1) + "\n";
  write_whole(stem + ".csv", study::as_csv(study, designs));
  write_whole(stem + ".json", json);
  write_whole(stem + ".md", study::as_markdown(study, designs));
  write_designs_page(stem + ".html", study, designs);
  if (arguments.json) {
    fmt::print("{}", json);
  } else if (!is_quiet) {
    print_designs(study, designs);
    fmt::print("written: {0}.html, .csv, .json and .md\n", stem);
  }
}

int run(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  if (arguments.schema) {
    fmt::print("{}", input::reference_page(study::study_schema()));
    return 0;
  }
  if (arguments.file.empty()) throw input::InputError("no study file given; see flexura study --help");
  if (arguments.jobs < 1)
    throw std::invalid_argument(fmt::format("--jobs is {}, it must be at least 1", arguments.jobs));
  std::string stem = arguments.output;
  if (stem.empty()) stem = std::filesystem::path(arguments.file).stem().string();
  files::require_stem(stem);
  files::Claims claims;
  if (arguments.share.empty())  // a share only fills the cache
    for (const char* const ending : {".html", ".csv", ".json", ".md", ".svg"}) claims.add(stem + ending);
  const StudyFile study = study::read_study(arguments.file, arguments.set);
  const std::filesystem::path bin = program_folder();
  terminal::Progress progress(stderr, verbosity.quiet);
  study::MeasureOptions options;
  options.jobs = arguments.jobs;
  options.fresh = arguments.fresh;
  options.run_scripts = arguments.run_scripts;
  options.progress = [&](std::string_view stage, double fraction) { progress(stage, fraction); };
  options.note = [&](std::string_view words) {
    if (verbosity.quiet) return;
    progress.clear();
    terminal::say(stderr, fmt::format("note: {}", words));
  };
  read_share(arguments.share, options);
  const study::Measurements measured = [&] {
    const files::StopRequests signals;
    try {
      return study::measure(study, {bin / "flexura", bin / "flexura-reduce", bin / "flexura-mesh"}, options);
    } catch (const study::Interrupted& end) {
      throw std::runtime_error(fmt::format(
          "the study was {}; what was measured until then is in {}: the same command goes on from there",
          end.what(), study.cache.string()));
    }
  }();
  progress.finish();
  if (!measured.whole) {
    if (!verbosity.quiet && !arguments.json)
      fmt::print("share {} is in {}; run the study without --share to gather all\n", arguments.share,
                 study.cache.string());
    return 0;
  }
  if (study.compares_designs()) {
    tell_designs(study, measured, stem, arguments, verbosity.quiet);
    return 0;
  }
  const Judgement judgement = study::judge(study, measured);
  write_whole(stem + ".csv", study::as_csv(study, judgement));
  const std::string json =
      study::as_json(study, judgement, std::string("flexura ") + FLEXURA_VERSION).dump(1) + "\n";
  write_whole(stem + ".json", json);
  std::vector<study::PicturePoint> points;
  for (const Row& row : judgement.rows)
    points.push_back({row.price, row.error.against_reference, row.on_front, row.choice->name});
  write_whole(stem + ".svg", study::front_picture({study.name,
                                                   study.cpu_is_cost ? "processor time of the whole program"
                                                                     : "wall time of the whole program",
                                                   std::move(points), judgement.largest_uncertainty}));
  write_whole(stem + ".md",
              study::as_markdown(study, judgement, std::filesystem::path(stem).filename().string() + ".svg"));
  view::write_report_page(stem + ".html", report_of(study, judgement));
  if (arguments.json) {
    fmt::print("{}", json);
  } else if (!verbosity.quiet) {
    print_table(study, judgement);
    fmt::print("written: {0}.html, .csv, .json, .md and .svg\n", stem);
  }
  return 0;
}

}  // namespace

terminal::Command study_command() {
  return {
      "study",
      "measure the trade of speed against accuracy over a ladder of choices, or find the best of designs",
      [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
        auto a = std::make_shared<Arguments>();
        options.optional_argument("FILE", a->file, "study file (.toml)")
            .option("-o,--output", a->output, "STEM",
                    "write STEM.html, .csv, .json, .md and .svg (default: the study file's name)")
            .option("-j,--jobs", a->jobs, "N",
                    "first runs and reductions side by side; times are taken one run at a time (1)")
            .option("--share", a->share, "I/N",
                    "run only the I-th of N shares into the cache, for job arrays and MPI ranks; then run "
                    "without it to gather")
            .option("--set", a->set, "KEY=VALUE", "override a key of the study file, as in repeats=5")
            .flag("--fresh", a->fresh, "measure again what the cache has")
            .flag("--run-scripts", a->run_scripts, "of the parts: as of flexura reduce")
            .flag("--json", a->json, "print what STEM.json holds")
            .flag("--schema", a->schema, "print the study file's reference page, then stop")
            .example("flexura study engine_study.toml -o out/engine", "table, front, answers")
            .example("flexura study engine_study.toml --share 2/8", "the second job of an array of eight");
        return [a, &verbosity] { return run(*a, verbosity); };
      }};
}

}  // namespace flexura::app
