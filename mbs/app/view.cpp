// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <filesystem>

#include "mbs/app/commands.hpp"
#include "mbs/results/results.hpp"
#include "mbs/view/pages.hpp"

namespace flexura::app {
namespace {

struct Arguments {
  std::string file, html;
  std::vector<std::string> plots;
  int frames = view::MotionPage{}.most_frames;
};

int run(const Arguments& arguments, const terminal::Talk& talk) {
  if (arguments.frames < 2)
    throw std::invalid_argument(fmt::format("--frames is {}, it must be at least 2", arguments.frames));
  const results::Results results = results::read(arguments.file);
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
                .example("flexura view engine.h5 -o engine.html", "look at it in a browser")
                .example("flexura view engine.h5 --plot crank.speed energy.kinetic,energy.strain",
                         "two plots, the second with two curves for each run");
            return [arguments, &talk] { return run(*arguments, talk); };
          }};
}

}  // namespace flexura::app
