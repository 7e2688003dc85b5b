// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/app/run/results_page.hpp"
#include "mbs/app/run/results_summary.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/view/pages.hpp"

namespace flexura::app {
namespace {

struct Arguments {
  std::string file, html;
  std::vector<std::string> plots;
  int frames = view::MotionPage{}.most_frames;
  bool summary = false, json = false;
};

int run(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  if (arguments.frames < 2)
    throw std::invalid_argument(fmt::format("--frames is {}, it must be at least 2", arguments.frames));
  std::filesystem::path html = arguments.html;
  if (html.empty() && !arguments.summary && !arguments.json)
    html = std::filesystem::path(arguments.file).replace_extension(".html");
  files::Claims claims;
  claims.add(html);
  const results::Results results = results::read(arguments.file);
  if (arguments.json) {
    fmt::print("{}\n", summary_json("results", results).dump(1));
  } else if (arguments.summary) {
    fmt::print("{}", summary_text(results, terminal::width(stdout), terminal::takes_colour(stdout)));
  }
  if (html.empty()) return 0;
  view::MotionPage page;
  page.plots = arguments.plots;
  page.most_frames = arguments.frames;
  const std::string written = write_results_page(html, results, arguments.file, page);
  if (!verbosity.quiet && !arguments.json) fmt::print("wrote {}\n", written);
  return 0;
}

}  // namespace

terminal::Command view_command() {
  return {"view", "write a page on which a simulated mechanism moves, with plots of its quantities",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto arguments = std::make_shared<Arguments>();
            options.argument("RESULTS", arguments->file, "results file; superelements lie where it says")
                .option("-o,--output", arguments->html, "PAGE", "the page (otherwise RESULTS with .html)")
                .option("--plot", arguments->plots, "NAME",
                        "plot this quantity at first; names joined by commas share a plot")
                .option("--frames", arguments->frames, "N", "keep at most this many poses of each run")
                .flag("--summary", arguments->summary,
                      "print how the runs ended and the range of each quantity; with -o also write the page")
                .flag("--json", arguments->json, "the same as JSON, SI units, with all digits")
                .example("flexura view engine.h5 -o engine.html", "look at it in a browser")
                .example("flexura view engine.h5 --summary", "how it went, in the terminal")
                .example("flexura view engine.h5 --plot crank.speed energy.kinetic,energy.strain",
                         "two plots, the second with two curves for each run");
            return [arguments, &verbosity] { return run(*arguments, verbosity); };
          }};
}

}  // namespace flexura::app
