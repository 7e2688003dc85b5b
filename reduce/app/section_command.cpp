// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/section_command.hpp"

#include <fmt/format.h>

#include <iostream>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/superelement/text_file.hpp"
#include "reduce/app/section_report.hpp"
#include "reduce/file/section_file.hpp"
#include "reduce/file/section_result.hpp"

namespace flexura::reduce {
namespace {

struct Arguments {
  std::string input, output, svg, size;
  std::vector<std::string> overrides;
  bool json = false, schema = false;
};

int solve_section(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  if (arguments.schema) {
    std::cout << input::reference_page(section_file_schema());
    return 0;
  }
  if (arguments.input.empty())
    throw input::InputError("no section file given; see flexura section --help, or --schema for its keys");
  std::vector<std::string> overrides = arguments.overrides;
  if (!arguments.size.empty()) overrides.push_back("size=" + arguments.size);
  const std::filesystem::path source = arguments.input;
  std::filesystem::path output = arguments.output, drawing = arguments.svg;
  if (output.empty()) output = std::filesystem::path(source).replace_extension(".section");
  if (drawing.empty()) drawing = std::filesystem::path(output).replace_extension(".svg");
  const auto same = [](const std::filesystem::path& a, const std::filesystem::path& b) {
    std::error_code unknown;  // links that lead to themselves: the claims say so
    const auto first = std::filesystem::weakly_canonical(a, unknown);
    return !unknown && first == std::filesystem::weakly_canonical(b, unknown) && !unknown;
  };
  if (same(output, source) || same(drawing, source) || same(output, drawing))
    throw input::InputError(
        fmt::format("{} would be overwritten by what is made of it; choose other names with -o and --svg",
                    source.string()));
  files::Claims claims;
  claims.add(output).add(drawing);
  std::vector<std::string> warnings;
  const beam::SectionProperties section = solve(read_section_file(source, overrides), &warnings);
  superelement::write_whole(output, section_result(section));
  superelement::write_whole(drawing, section_svg(section));
  for (const std::string& warning : warnings) terminal::say(stderr, "warning: " + warning);
  if (arguments.json) {
    std::cout << section_json(section) << '\n';
  } else if (!verbosity.quiet) {
    print_section(section, std::cout);
    fmt::print("wrote {} and {}\n", output.string(), drawing.string());
  }
  return 0;
}

}  // namespace

terminal::Command section_command() {
  return {"flexura section", "constants of any cross-section, for beams",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            const auto arguments = std::make_shared<Arguments>();
            options
                .optional_argument("FILE", arguments->input,
                                   "section file (.toml): polygons with holes, thin walls, or a CAD face")
                .option("-o,--output", arguments->output, "FILE",
                        "section file for beam parts, `type = \"file\"` (default: FILE.section)")
                .option("--svg", arguments->svg, "FILE", "the drawing (default: beside the section file)")
                .option("--size,--mesh-size", arguments->size, "LENGTH",
                        "element size, overrides size: \"2 mm\"")
                .option("--set", arguments->overrides, "KEY=VALUE", "override an entry of the file")
                .flag("--json", arguments->json, "print JSON instead of the table")
                .flag("--schema", arguments->schema, "print the section file's reference page, then stop")
                .example("flexura section channel.toml", "table; channel.section and channel.svg")
                .example("flexura section channel.toml --size \"1 mm\"", "the same on a finer mesh");
            return [arguments, &verbosity] { return solve_section(*arguments, verbosity); };
          }};
}

}  // namespace flexura::reduce
