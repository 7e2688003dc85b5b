// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// flexura-reduce: turns a CAD part or a beam model into a superelement.  `flexura reduce` and `flexura
// section` hand over to it.
#include <fmt/format.h>

#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>
#include <stdexcept>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/terminal/command_line.hpp"
#include "mbs/base/terminal/harmless_stream.hpp"
#include "mbs/base/threads/pool.hpp"
#include "reduce/app/attach_solid.hpp"
#include "reduce/app/beam_modes.hpp"
#include "reduce/app/beam_statics.hpp"
#include "reduce/app/list_faces.hpp"
#include "reduce/app/section_command.hpp"
#include "reduce/app/write_reduced.hpp"
#include "reduce/cms/team_reduction.hpp"
#include "reduce/file/beam_file.hpp"
#include "reduce/file/flexdata_file.hpp"
#include "reduce/file/foreign_formats.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/linalg/dense/blas_kernels.hpp"
#include "reduce/linalg/dense/blas_threads.hpp"
#include "reduce/linalg/petsc/team.hpp"
#include "reduce/linalg/session/session.hpp"
#include "reduce/linalg/session/user_options.hpp"
#include "reduce/part/write_mesh.hpp"

namespace {

using namespace flexura;

// --html without a name.
const char* const kBesidePart = "PART.faces.html";
constexpr int kNotGiven = std::numeric_limits<int>::min();

struct Arguments {
  std::string input, output, report, html, mesh, mesh_size, accuracy, petsc, unit_system, density;
  std::vector<std::string> overrides, held;
  int modes = -1, beam_modes = 0, compare = 0;
  int places = kNotGiven, threads = kNotGiven;
  int places_or_default() const { return places == kNotGiven ? 5 : places; }
  bool strict = false, factor_in_file = false, list_faces = false, schema = false, schema_beams = false,
       schema_flexdata = false, statics = false, run_scripts = false;
};

// What --unit-system says in the part file's words.
std::vector<std::string> overrides_of_units(const std::string& system) {
  struct System {
    const char *name, *length, *mass;
  };
  constexpr System kSystems[] = {{"m-kg-s", "m", "kg"},
                                 {"mm-t-s", "mm", "t"},
                                 {"mm-kg-s", "mm", "kg"},
                                 {"cm-g-s", "cm", "g"},
                                 {"inch-lbf-s", "inch", "lbf s^2/in"},
                                 {"ft-slug-s", "ft", "slug"}};
  std::vector<std::string> known;
  for (const System& s : kSystems) {
    if (system == s.name)
      return {fmt::format("geometry.unit=\"{}\"", s.length),
              fmt::format("geometry.mass_unit=\"{}\"", s.mass)};
    known.emplace_back(s.name);
  }
  throw input::InputError(
      fmt::format("--unit-system {}: is not a known system{}", system, input::suggestion(system, known)));
}

// What one kind of part knows and the other does not is refused, not passed over.
void refuse_options_of_the_other_kind(const Arguments& a, bool is_beam) {
  const auto refuse = [&](bool given, const char* option, const char* whose) {
    if (given)
      throw input::InputError(
          fmt::format("{}: {} is for {}, which this is not: leave it out", a.input, option, whose));
  };
  if (is_beam) {
    refuse(a.compare > 0, "--compare", "parts of solid elements");
    refuse(!a.accuracy.empty(), "--accuracy", "parts of solid elements");
    refuse(!a.mesh.empty(), "--mesh", "parts of solid elements");
    refuse(a.factor_in_file, "--factor-in-file", "parts of solid elements");
    refuse(!a.petsc.empty(), "--petsc", "parts of solid elements");
    refuse(!a.unit_system.empty(), "--unit-system", "parts of solid elements");
    refuse(!a.density.empty(), "--density", "decks");
    refuse(a.strict, "--strict", "decks");
    if (!a.statics && (!a.held.empty() || a.places != kNotGiven))
      throw input::InputError("--held and --places are for --statics: give it, or leave them out");
    if (a.statics && a.beam_modes > 0)
      throw input::InputError("--statics and --beam-modes exclude each other");
  } else {
    refuse(a.beam_modes > 0, "--beam-modes", "beam parts");
    refuse(a.statics, "--statics", "beam parts");
    refuse(!a.held.empty(), "--held", "beam parts");
    refuse(a.places != kNotGiven, "--places", "beam parts");
  }
}

// FlexData files hold finished modes.
void refuse_options_of_reductions(const Arguments& a) {
  const std::pair<bool, const char*> given[] = {{!a.mesh_size.empty(), "--mesh-size"},
                                                {!a.accuracy.empty(), "--accuracy"},
                                                {a.modes >= 0, "--modes"},
                                                {!a.mesh.empty(), "--mesh"},
                                                {a.compare > 0, "--compare"},
                                                {a.factor_in_file, "--factor-in-file"},
                                                {!a.petsc.empty(), "--petsc"},
                                                {!a.unit_system.empty(), "--unit-system"},
                                                {!a.density.empty(), "--density"},
                                                {a.strict, "--strict"}};
  for (const auto& [is_given, option] : given)
    if (is_given)
      throw input::InputError(
          fmt::format("{}: {} is for parts that are reduced here; these modes are finished: leave it out",
                      a.input, option));
}

int list_faces(const Arguments& arguments) {
  std::filesystem::path html = arguments.html;
  if (html == kBesidePart) html = std::filesystem::path(arguments.input).replace_extension(".faces.html");
  if (!html.empty() && html.extension() != ".html")
    throw input::InputError(fmt::format("--html {}: must end in .html", html.string()));
  files::Claims claims;
  claims.add(html);
  reduce::print_faces(arguments.input, std::cout);
  if (!html.empty()) {
    reduce::write_faces_page(arguments.input, html);
    fmt::print("\nwrote {}\n", html.string());
  }
  return 0;
}

int reduce_with(const Arguments& arguments, const terminal::Verbosity& verbosity, const linalg::Team* team) {
  if (arguments.schema) {
    std::cout << input::reference_page(reduce::part_schema());
    return 0;
  }
  if (arguments.schema_beams) {
    std::cout << input::reference_page(reduce::beam_schema());
    return 0;
  }
  if (arguments.schema_flexdata) {
    std::cout << input::reference_page(reduce::flexdata_schema());
    return 0;
  }
  if (arguments.input.empty()) throw input::InputError("no part file given; see flexura reduce --help");
  if (arguments.threads != kNotGiven) {
    constexpr int most = 1024;
    if (arguments.threads < 1 || arguments.threads > most)
      throw input::InputError(
          fmt::format("--threads {}: must be at least 1 and at most {}", arguments.threads, most));
    threads::set_count(arguments.threads);
    linalg::set_blas_threads(arguments.threads);
  }
  if (arguments.list_faces) {
    return list_faces(arguments);
  }
  if (!arguments.html.empty())
    throw input::InputError(
        "--html is the picture of --list-faces: give that too; the page of a superelement is "
        "written by flexura modes --html");
  if (const std::string what = reduce::foreign_format(arguments.input); !what.empty())
    throw input::InputError(fmt::format("{}: {}", arguments.input, what));
  if (reduce::is_cad_ending(reduce::ending_of(arguments.input)))
    throw input::InputError(fmt::format(
        "{}: is a CAD file, a part file (.toml) that names it is wanted; --list-faces lists what its "
        "interfaces can be chosen from, --schema the part file's keys",
        arguments.input));
  std::vector<std::string> overrides = arguments.overrides;
  if (!arguments.mesh_size.empty()) overrides.push_back("mesh.size=" + arguments.mesh_size);
  if (!arguments.accuracy.empty()) overrides.push_back("modes.accuracy=" + arguments.accuracy);
  if (arguments.modes >= 0) overrides.push_back(fmt::format("modes.count={}", arguments.modes));
  if (!arguments.unit_system.empty())
    for (std::string& unit : overrides_of_units(arguments.unit_system)) overrides.push_back(std::move(unit));
  if (!arguments.density.empty()) overrides.push_back("geometry.density=" + arguments.density);
  if (arguments.strict) overrides.emplace_back("geometry.strict=true");
  constexpr int most = 20000;
  for (const auto& [name, count] :
       {std::pair{"--compare", arguments.compare}, std::pair{"--places", arguments.places_or_default()},
        std::pair{"--beam-modes", arguments.beam_modes}})
    if (count < 0 || count > most)
      throw input::InputError(fmt::format("{} {}: must be at least 0 and at most {}", name, count, most));
  std::filesystem::path output = arguments.output;
  if (output.empty()) output = std::filesystem::path(arguments.input).replace_extension(".se.h5");
  const bool prints_only = arguments.statics || arguments.beam_modes > 0;  // of beam parts
  files::require_no_device(arguments.input);
  const bool is_beam = reduce::is_beam_file(arguments.input);
  const bool is_flexdata = !is_beam && reduce::is_flexdata_file(arguments.input);
  refuse_options_of_the_other_kind(arguments, is_beam);
  if (is_flexdata) refuse_options_of_reductions(arguments);
  files::Claims claims;
  if (!prints_only || !is_beam) claims.add(output);
  claims.add(arguments.report);
  if (!arguments.mesh.empty() && !reduce::is_mesh_ending(arguments.mesh))
    throw input::InputError(
        fmt::format("--mesh {}: must end in .inp (Abaqus), .vtu (ParaView) or .msh (gmsh)", arguments.mesh));
  claims.add(arguments.mesh);
  if (is_flexdata) {
    reduce::reduce_to_file(reduce::read_flexdata_part(arguments.input, arguments.overrides), output,
                           {.report = arguments.report, .quiet = verbosity.quiet});
    return 0;
  }
  if (is_beam) {
    const linalg::Session session;  // one for the structure and its solids
    const reduce::BeamPartInput beams = reduce::read_beam_part(
        arguments.input, overrides,
        [&](const reduce::SolidInput& solid) {
          return reduce::attach_solid(solid, output, {.report = {}, .quiet = verbosity.quiet});
        },
        arguments.run_scripts);
    if (arguments.beam_modes > 0) {
      reduce::print_beam_modes(beams, arguments.beam_modes, std::cout);
      return 0;
    }
    if (arguments.statics) {
      reduce::print_statics(beams, arguments.held, arguments.places_or_default(), std::cout,
                            arguments.report);
      return 0;
    }
    reduce::reduce_to_file(beams, output, {.report = arguments.report, .quiet = verbosity.quiet});
    return 0;
  }
  const reduce::PartInput part = reduce::read_part(arguments.input, overrides);
  std::vector<linalg::UserOption> petsc;
  try {
    petsc = linalg::parse_options(arguments.petsc);
  } catch (const std::invalid_argument& error) {
    throw input::InputError(fmt::format("--petsc: {}", error.what()));
  }

  reduce::reduce_to_file(part, output,
                         {.report = arguments.report,
                          .mesh = arguments.mesh,
                          .compare = arguments.compare,
                          .team = team,
                          .petsc = std::move(petsc),
                          .factor_in_file = arguments.factor_in_file,
                          .quiet = verbosity.quiet});
  return 0;
}

std::function<int()> declare(terminal::Options& options, const terminal::Verbosity& verbosity,
                             const linalg::Team* team) {
  const auto arguments = std::make_shared<Arguments>();
  options
      .optional_argument("PART", arguments->input,
                         "part file (.toml) or FlexData (.xml); with --list-faces also a CAD file")
      .option("-o,--output", arguments->output, "FILE", "superelement to write (default: PART.se.h5)")
      .option("--mesh-size,--size", arguments->mesh_size, "LENGTH",
              "element size, overrides mesh.size: \"2 mm\"")
      .option("--accuracy", arguments->accuracy, "PERCENT",
              "choose mesh and modes for this accuracy, overrides modes.accuracy: \"1 %\"")
      .option("-n,--modes,--count", arguments->modes, "N", "number of normal modes, overrides modes.count")
      .option("--beam-modes", arguments->beam_modes, "N",
              "beam parts: print N natural frequencies of the free structure, nothing reduced, then stop")
      .flag("--statics", arguments->statics,
            "beam parts: print what the load cases do with the interfaces held, then stop")
      .option("--held", arguments->held, "INTERFACE ...", "interfaces that --statics holds (default: all)")
      .option("--places", arguments->places, "N", "places along each member for --statics (default: 5)")
      .option("--set", arguments->overrides, "KEY=VALUE", "override an entry of the part file")
      .option("--unit-system", arguments->unit_system, "SYSTEM",
              "units of a mesh file or deck, overrides geometry.unit and geometry.mass_unit: m-kg-s, mm-t-s, "
              "mm-kg-s, cm-g-s, inch-lbf-s, ft-slug-s")
      .option("--density", arguments->density, "DENSITY",
              "of a deck's materials that have none, overrides geometry.density: \"7800 kg/m^3\"")
      .flag("--strict", arguments->strict,
            "refuse a deck of which something is left out or repaired that changes the body")
      .option("--report", arguments->report, "FILE", "also write the acceptance report as JSON")
      .option(
          "--mesh", arguments->mesh, "FILE",
          "also write the mesh of solids and shells, in m: .inp (Abaqus, with materials and sections), .vtu "
          "(ParaView) or .msh (gmsh)")
      .option(
          "--compare", arguments->compare, "N",
          "also solve the full model: N free frequencies and static compliance against the superelement's")
      .flag("--factor-in-file", arguments->factor_in_file,
            "keep the factor in a temporary file (in TMPDIR or beside the output), as is done by itself "
            "where it does not fit into memory")
      .option("--threads", arguments->threads, "N",
              "threads that share the work (default: one for each core)")
      .option("--petsc", arguments->petsc, "OPTIONS",
              "options of PETSc and SLEPc as one text, after those of the part file's [solver]: \"-eps_view "
              "-log_view\" "
              "shows their reports")
      .flag("--list-faces", arguments->list_faces, "list the solids and faces of the part, then stop")
      .optional_value(
          "--html", arguments->html, kBesidePart, "FILE",
          "with --list-faces: also a page with the part, numbers on its faces and the interfaces chosen from "
          "them (default: PART.faces.html)")
      .flag("--run-scripts", arguments->run_scripts,
            "beam parts: let gmsh run the .geo scripts that [curves.NAME] names; look through them first")
      .flag("--schema", arguments->schema, "print the part file's reference page, then stop")
      .flag("--schema-flexdata", arguments->schema_flexdata,
            "print the reference page of part files for FlexData, then stop")
      .flag("--schema-beams", arguments->schema_beams, "print the beam part file's reference page, then stop")
      .example("flexura reduce --list-faces bracket.step", "what an interface can be chosen from")
      .example("flexura reduce --list-faces bracket.step --html faces.html", "the same to click on")
      .example("flexura reduce conrod.toml -o conrod.se.h5", "mesh, reduce, write")
      .example("flexura reduce conrod.toml --accuracy \"1 %\"",
               "mesh anew until frequencies and static compliance are within 1 %")
      .example("flexura reduce conrod.toml -o fine.se.h5 --mesh-size \"2 mm\" --set modes.count=40",
               "finer, with more modes");
  return [arguments, &verbosity, team] { return reduce_with(*arguments, verbosity, team); };
}

// Where memory is short a thread of OpenBLAS may ask for it for ever, from the program's start on, and the end of
// the process would wait for that thread: everything of ours is done by now, so the rest is left to the kernel.
int end(int code) {
  try {
    linalg::require_blas_memory(1);
  } catch (const std::runtime_error&) {
    std::cout.flush();
    std::fflush(nullptr);
    std::_Exit(code);
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  linalg::choose_kernels(argv);
  const std::string kernels = linalg::kernels_in_use(),
                    version = FLEXURA_VERSION + (kernels.empty() ? "" : "\nkernels: " + kernels);
  // Under mpirun the first process reads, leads and writes; the others do their shares of elements,
  // factorisations and solves until it ends.
  std::optional<linalg::Session> session;
  std::optional<linalg::Team> team;
  if (linalg::launch().size > 1) {
    terminal::guard_standard_streams();  // which PETSc keeps
    session.emplace();
    team.emplace();
    if (team->rank() > 0) {
      reduce::serve(*team);
      return 0;
    }
  }
  // `flexura section` is handed over as "flexura-reduce section ...".
  if (argc > 1 && std::string(argv[1]) == "section")
    return end(terminal::run(reduce::section_command(), version, argc - 1, argv + 1));
  const int code = terminal::run({.name = "flexura reduce",
                                  .summary = "make a superelement of a CAD part",
                                  .declare =
                                      [&](terminal::Options& options, const terminal::Verbosity& verbosity) {
                                        return declare(options, verbosity, team ? &*team : nullptr);
                                      }},
                                 version, argc, argv);
  return session ? code : end(code);  // others wait for the first process
}
