// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "mbs/app/commands.hpp"
#include "mbs/app/film/browser.hpp"
#include "mbs/app/film/film.hpp"
#include "mbs/app/run/results_page.hpp"
#include "mbs/app/run/results_summary.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/view/pages.hpp"

namespace flexura::app {
namespace {

struct Arguments {
  std::string file, html, film;
  FilmOptions how;
  std::vector<std::string> plots;
  int frames = view::MotionPage{}.most_frames;
  bool summary = false, json = false;
};

/// Removed with all that is in it.
struct ScratchFolder {
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "flexura-film-XXXXXX").string();
    if (!::mkdtemp(name.data()))
      throw std::runtime_error(fmt::format("cannot make the folder '{}': {}", name, std::strerror(errno)));
    path = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path path;
};

int run(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  if (arguments.frames < 2)
    throw std::invalid_argument(fmt::format("--frames is {}, it must be at least 2", arguments.frames));
  std::filesystem::path html = arguments.html;
  const bool films = !arguments.film.empty();
  if (films) check_film(arguments.film, arguments.how);
  if (html.empty() && !arguments.summary && !arguments.json && !films)
    html = std::filesystem::path(arguments.file).replace_extension(".html");
  files::Claims claims;
  claims.add(html).add(arguments.film);
  if (films) find_browser();
  const results::Results results = results::read(arguments.file);
  if (arguments.json) {
    fmt::print("{}\n", summary_json("results", results).dump(1));
  } else if (arguments.summary) {
    fmt::print("{}", summary_text(results, terminal::width(stdout), terminal::takes_colour(stdout)));
  }
  if (html.empty() && !films) return 0;
  // A film alone is of a page that nobody keeps.
  std::optional<ScratchFolder> scratch;
  if (html.empty()) html = scratch.emplace().path / "film.html";
  view::MotionPage page;
  page.plots = arguments.plots;
  page.most_frames = arguments.frames;
  const std::string written = write_results_page(html, results, arguments.file, page);
  const bool tells = !verbosity.quiet && !arguments.json;
  if (tells && !scratch) fmt::print("wrote {}\n", written);
  if (films) {
    write_film(arguments.film, html, arguments.how);
    if (tells)
      fmt::print("wrote {} ({:.1f} MB)\n", arguments.film,
                 static_cast<double>(std::filesystem::file_size(arguments.film)) / 1e6);
  }
  return 0;
}

}  // namespace

terminal::Command view_command() {
  return {"view", "write a page on which a simulated mechanism moves, with plots of its quantities",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto arguments = std::make_shared<Arguments>();
            options.argument("RESULTS", arguments->file, "results file; superelements lie where it says")
                .option("-o,--output", arguments->html, "PAGE", "the page (otherwise RESULTS with .html)")
                .option("--film", arguments->film, "FILM",
                        "a film of the motion (.mp4, .webm, .gif), drawn frame by frame in a browser of this "
                        "machine (Chromium)")
                .option("--film-size", arguments->how.size, "WxH", "of the film [px]")
                .option("--film-seconds", arguments->how.seconds, "S",
                        "how long it lasts (otherwise as the page plays it)")
                .option("--film-fps", arguments->how.fps, "N", "frames in a second")
                .option("--film-view", arguments->how.view, "VIEW", "+x, -x, +y, -y, +z, -z or iso")
                .option("--film-color", arguments->how.color, "WHAT", "displacement, stress or bodies")
                .option("--plot", arguments->plots, "NAME",
                        "plot this quantity at first; names joined by commas share a plot")
                .option("--frames", arguments->frames, "N", "keep at most this many poses of each run")
                .flag("--summary", arguments->summary,
                      "print how the runs ended and the range of each quantity; with -o also write the page")
                .flag("--json", arguments->json, "the same as JSON, SI units, with all digits")
                .example("flexura view engine.h5 -o engine.html", "look at it in a browser")
                .example("flexura view engine.h5 --summary", "how it went, in the terminal")
                .example("flexura view engine.h5 --plot crank.speed energy.kinetic,energy.strain",
                         "two plots, the second with two curves for each run")
                .example("flexura view engine.h5 --film engine.mp4 --film-color stress", "for a talk");
            return [arguments, &verbosity] { return run(*arguments, verbosity); };
          }};
}

}  // namespace flexura::app
