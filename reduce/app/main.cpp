// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// flexura-reduce: turns a CAD part into a superelement.  `flexura reduce` hands over to it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "mbs/input/document.hpp"
#include "mbs/terminal/terminal.hpp"
#include "reduce/app/list_faces.hpp"
#include "reduce/app/part_file.hpp"
#include "reduce/app/reduce_part.hpp"

namespace {

using namespace flexura;

struct Arguments {
  std::filesystem::path input, output, report;
  std::vector<std::string> overrides;
  std::string mesh_size;
  int modes = -1;
  bool list_faces = false, schema = false, quiet = false;
};

const char* const kExamples = R"(Examples:
  flexura reduce --list-faces bracket.step        what an interface can be chosen from
  flexura reduce conrod.toml -o conrod.se.h5      mesh, reduce, write
  flexura reduce conrod.toml -o fine.se.h5 --mesh-size "2 mm" --set modes.count=40
The part file's reference page is cases/PART_FILE.md (also: flexura reduce --schema).)";

void add_options(CLI::App& app, Arguments& arguments) {
  app.add_option("part", arguments.input, "part file (.toml); with --list-faces also a CAD file");
  app.add_option("-o,--output", arguments.output, "superelement to write (default: PART.se.h5)");
  app.add_option("--mesh-size", arguments.mesh_size, "element size, overrides mesh.size: \"2 mm\"");
  app.add_option("--modes", arguments.modes, "number of normal modes, overrides modes.count");
  app.add_option("--set", arguments.overrides, "override an entry of the part file: KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--report", arguments.report, "also write the reduction's report as JSON");
  app.add_flag("--list-faces", arguments.list_faces, "list the solids and faces of the part, then stop");
  app.add_flag("--schema", arguments.schema, "print the part file's reference page, then stop");
  app.add_flag("-q,--quiet", arguments.quiet, "no progress, no summary");
  app.footer(kExamples);
}

int run(const Arguments& arguments) {
  if (arguments.schema) {
    std::cout << input::reference_page(reduce::part_schema());
    return 0;
  }
  if (arguments.input.empty()) throw input::InputError("no part file given; see flexura reduce --help");
  if (arguments.list_faces) {
    reduce::print_faces(arguments.input, std::cout);
    return 0;
  }
  std::vector<std::string> overrides = arguments.overrides;
  if (!arguments.mesh_size.empty()) overrides.push_back("mesh.size=" + arguments.mesh_size);
  if (arguments.modes >= 0) overrides.push_back(fmt::format("modes.count={}", arguments.modes));
  const reduce::PartInput part = reduce::read_part(arguments.input, overrides);

  std::filesystem::path output = arguments.output;
  if (output.empty()) output = std::filesystem::path(arguments.input).replace_extension(".se.h5");
  reduce::reduce_part(part, output, {.report = arguments.report, .quiet = arguments.quiet});
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"flexura reduce: a CAD part becomes a superelement", "flexura reduce"};
  Arguments arguments;
  add_options(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return run(arguments);
  } catch (const input::InputError& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 2;
  } catch (const std::invalid_argument& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
}
