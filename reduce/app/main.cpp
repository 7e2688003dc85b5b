// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// flexura-reduce: turns a CAD part into a superelement.  `flexura reduce` hands over to it.
#include <fmt/format.h>

#include <fstream>
#include <iostream>

#include "mbs/input/document.hpp"
#include "mbs/terminal/command_line.hpp"
#include "reduce/app/beam_file.hpp"
#include "reduce/app/list_faces.hpp"
#include "reduce/app/part_file.hpp"
#include "reduce/app/reduce_beam_part.hpp"
#include "reduce/app/reduce_part.hpp"
#include "reduce/app/section_file.hpp"

namespace {

using namespace flexura;

struct Arguments {
  std::string input, output, report, mesh_size;
  std::vector<std::string> overrides;
  int modes = -1, beam_modes = 0;
  bool list_faces = false, schema = false, schema_beams = false, section = false, schema_section = false;
};

// Writes beside and renames, so that no half-written file is left.
void write_file(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::path beside = file;
  beside += ".part";
  std::ofstream out(beside);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file.string() + " cannot be written");
  std::filesystem::rename(beside, file);
}

void solve_section(const Arguments& arguments, const terminal::Talk& talk) {
  const beam::SectionProperties section =
      reduce::solve(reduce::read_section_file(arguments.input, arguments.overrides));
  if (!talk.quiet) reduce::print_section(section, std::cout);
  std::filesystem::path output = arguments.output;
  if (output.empty()) output = std::filesystem::path(arguments.input).replace_extension(".section");
  write_file(output, reduce::section_result(section));
  std::filesystem::path drawing = output;
  drawing.replace_extension(".svg");
  write_file(drawing, reduce::section_svg(section));
  if (!talk.quiet) fmt::print("wrote {} and {}\n", output.string(), drawing.string());
}

int reduce_with(const Arguments& arguments, const terminal::Talk& talk) {
  if (arguments.schema) {
    std::cout << input::reference_page(reduce::part_schema());
    return 0;
  }
  if (arguments.schema_beams) {
    std::cout << input::reference_page(reduce::beam_schema());
    return 0;
  }
  if (arguments.schema_section) {
    std::cout << input::reference_page(reduce::section_file_schema());
    return 0;
  }
  if (arguments.input.empty()) throw input::InputError("no part file given; see flexura reduce --help");
  if (arguments.section) {
    solve_section(arguments, talk);
    return 0;
  }
  if (arguments.list_faces) {
    reduce::print_faces(arguments.input, std::cout);
    return 0;
  }
  std::vector<std::string> overrides = arguments.overrides;
  if (!arguments.mesh_size.empty()) overrides.push_back("mesh.size=" + arguments.mesh_size);
  if (arguments.modes >= 0) overrides.push_back(fmt::format("modes.count={}", arguments.modes));
  std::filesystem::path output = arguments.output;
  if (output.empty()) output = std::filesystem::path(arguments.input).replace_extension(".se.h5");
  if (reduce::is_beam_file(arguments.input)) {
    const reduce::BeamPartInput beams = reduce::read_beam_part(arguments.input, overrides);
    if (arguments.beam_modes > 0) {
      reduce::print_beam_modes(beams, arguments.beam_modes, std::cout);
      return 0;
    }
    reduce::reduce_beam_part(beams, output, {.report = arguments.report, .quiet = talk.quiet});
    return 0;
  }
  const reduce::PartInput part = reduce::read_part(arguments.input, overrides);

  reduce::reduce_part(part, output, {.report = arguments.report, .quiet = talk.quiet});
  return 0;
}

std::function<int()> declare(terminal::Options& options, const terminal::Talk& talk) {
  const auto arguments = std::make_shared<Arguments>();
  options.optional_argument("PART", arguments->input, "part file (.toml); with --list-faces also a CAD file")
      .option("-o,--output", arguments->output, "FILE", "superelement to write (default: PART.se.h5)")
      .option("--mesh-size", arguments->mesh_size, "LENGTH", "element size, overrides mesh.size: \"2 mm\"")
      .option("--modes", arguments->modes, "N", "number of normal modes, overrides modes.count")
      .option("--beam-modes", arguments->beam_modes, "N",
              "beam parts: print N natural frequencies of the free structure, nothing reduced, then stop")
      .option("--set", arguments->overrides, "KEY=VALUE", "override an entry of the part file")
      .option("--report", arguments->report, "FILE", "also write the reduction's report as JSON")
      .flag("--list-faces", arguments->list_faces, "list the solids and faces of the part, then stop")
      .flag("--schema", arguments->schema, "print the part file's reference page, then stop")
      .flag("--section", arguments->section,
            "PART is a cross-section: print its constants, write FILE (default: PART.section) and a drawing, "
            "then stop")
      .flag("--schema-section", arguments->schema_section,
            "print the section file's reference page, then stop")
      .flag("--schema-beams", arguments->schema_beams, "print the beam part file's reference page, then stop")
      .example("flexura reduce --list-faces bracket.step", "what an interface can be chosen from")
      .example("flexura reduce conrod.toml -o conrod.se.h5", "mesh, reduce, write")
      .example("flexura reduce conrod.toml -o fine.se.h5 --mesh-size \"2 mm\" --set modes.count=40",
               "finer, with more modes");
  return [arguments, &talk] { return reduce_with(*arguments, talk); };
}

}  // namespace

int main(int argc, char** argv) {
  return terminal::run(
      {.name = "flexura reduce", .summary = "make a superelement of a CAD part", .declare = declare},
      FLEXURA_VERSION, argc, argv);
}
