// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/json_text.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/view/reports/reduction_report.hpp"

namespace flexura::app {
namespace {

struct Arguments {
  std::string file, html;
};

view::Report read_report(const std::string& file) {
  files::note_input(file);
  std::ifstream in(file);
  if (!in)
    throw std::invalid_argument(
        fmt::format("cannot read the report '{}': no such file; check its path", file));
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  nlohmann::json json;
  try {
    json = files::read_json(text);
  } catch (const nlohmann::json::parse_error& failure) {
    // Without the library's own number of the fault, "[json.exception.parse_error.101] ".
    const std::string what = failure.what();
    throw std::invalid_argument(
        fmt::format("'{}' is not JSON: {}; correct it there", file, what.substr(what.find("] ") + 2)));
  }
  try {
    return view::is_told_by_reduction(json) ? view::reduction_report(json) : view::report_from_json(json);
  } catch (const std::invalid_argument& failure) {
    throw std::invalid_argument(fmt::format("'{}': {}", file, failure.what()));
  }
}

int run(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  std::filesystem::path html = arguments.html;
  if (html.empty()) html = std::filesystem::path(arguments.file).replace_extension(".html");
  files::Claims claims;
  claims.add(html);
  const bool is_json = arguments.file.ends_with(".json");
  const view::Report report =
      is_json ? read_report(arguments.file)
              : view::reduction_report(
                    superelement::read(arguments.file, {.matrices = true, .inertia = true, .surface = true}));
  view::write_report_page(html, report);
  if (!verbosity.quiet) fmt::print("wrote {}\n", html.string());
  return 0;
}

}  // namespace

terminal::Command report_command() {
  return {"report", "write a page that reports on a reduction, or on tables and plots given as JSON",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto arguments = std::make_shared<Arguments>();
            options
                .argument("FILE", arguments->file,
                          "superelement file (.h5), what reduce --report wrote, or a report (.json)")
                .option("-o,--output", arguments->html, "PAGE", "the page (otherwise FILE with .html)")
                .example("flexura report conrod.se.h5 -o conrod.report.html",
                         "mesh, modes, checks and times of the reduction")
                .example("flexura report conrod.report.json",
                         "the same of what flexura reduce --report conrod.report.json wrote")
                .example("flexura report extremes.json", "tables and plots of a program of your own");
            return [arguments, &verbosity] { return run(*arguments, verbosity); };
          }};
}

}  // namespace flexura::app
