// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <map>

#include "mbs/app/commands.hpp"
#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/app/urdf/urdf_export.hpp"
#include "mbs/base/files/new_folder.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/files/place.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/results/results.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/exchange/names.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/view/motion_vtk.hpp"
#include "mbs/view/node_motions.hpp"

namespace flexura::app {
namespace {

using superelement::ModeAnalysis;
using superelement::Superelement;

struct Arguments {
  std::string file, output, format, held = "none", run;
  int count = 30, frames = 200, id = -1;
};

// The formats that take a results file.
bool is_of_results(const std::string& format) {
  return format == "pvd" || format == "csv" || format == "nodes";
}

// "FILE.se.h5" without its endings, for the default name of the output.
std::filesystem::path stem_of(std::filesystem::path file) {
  file.replace_extension();
  if (file.extension() == ".se") file.replace_extension();
  return file;
}

int export_results(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  if (arguments.frames < 2)
    throw std::invalid_argument(fmt::format("--frames is {}, it must be at least 2", arguments.frames));
  std::filesystem::path stem = arguments.output.empty() ? arguments.file : arguments.output;
  const std::string ending = arguments.format == "nodes" ? "nodes.csv" : arguments.format;
  if (stem.extension() == ".h5" || stem.extension() == "." + arguments.format ||
      (arguments.format == "nodes" && stem.extension() == ".csv"))
    stem.replace_extension();
  files::require_stem(stem);
  const results::Results results = results::read(arguments.file);
  files::Claims claims;
  for (const results::Run& run : results.runs)
    claims.add(fmt::format("{}.{}.{}", stem.string(), run.name, ending));
  const auto written =
      arguments.format == "csv" ? results::write_csv(results, stem.string() + ".csv")
      : arguments.format == "nodes"
          ? view::write_node_motions(stem, results, arguments.file, arguments.frames)
          : view::write_motion_vtk(stem, results, view::read_pictures(results.model, arguments.file),
                                   arguments.frames);
  if (!verbosity.quiet) {
    for (const auto& path : written) fmt::print("wrote {}\n", path.string());
  }
  return 0;
}

// A mechanism file as a robot.
int export_urdf(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  const std::filesystem::path output = arguments.output.empty()
                                           ? std::filesystem::path(stem_of(arguments.file).string() + ".urdf")
                                           : std::filesystem::path(arguments.output);
  const std::filesystem::path folder = output.parent_path() / (output.stem().string() + "_meshes");
  MechanismArguments mechanism{.file = arguments.file};
  if (!arguments.run.empty()) mechanism.runs = {arguments.run};
  std::vector<NamedRun> runs = prepare_runs(mechanism);
  const Urdf urdf =
      to_urdf(*only_run(runs, mechanism, "--format urdf").prepared.mechanism, folder.filename().string());
  files::Claims claims;
  claims.add(output);
  std::optional<files::NewFolder> made;
  if (!urdf.meshes.empty()) made.emplace(folder);
  for (const auto& [name, content] : urdf.meshes) files::write_whole(folder / name, content);
  files::write_whole(output, urdf.text);
  if (verbosity.quiet) return 0;
  for (const std::string& note : urdf.notes) terminal::say(stderr, "note: " + note);
  fmt::print("wrote {}\n", output.string());
  return 0;
}

int run(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  if (arguments.format == "urdf") return export_urdf(arguments, verbosity);
  if (!arguments.run.empty())
    throw std::invalid_argument("--run chooses a run of a mechanism file, for --format urdf: leave it out");
  if (is_of_results(arguments.format)) return export_results(arguments, verbosity);
  if (arguments.count < 1)
    throw std::invalid_argument(fmt::format("--count is {}, it must be at least 1", arguments.count));
  const bool pictures = arguments.format == "vtk" || arguments.format == "gmsh" || arguments.format == "gltf";
  const bool matrices = arguments.format == "matrix-market" || arguments.format == "dmig";
  static const std::map<std::string, std::string> endings = {{"dmig", ".pch"},     {"sid", ".SID_FEM"},
                                                             {"flexdata", ".xml"}, {"vtk", ".vtp"},
                                                             {"gltf", ".glb"},     {"gmsh", ".msh"}};
  const auto ending = endings.find(arguments.format);
  const std::filesystem::path output =
      arguments.output.empty() ? std::filesystem::path(stem_of(arguments.file).string() +
                                                       (ending == endings.end() ? "" : ending->second))
                               : std::filesystem::path(arguments.output);
  if (arguments.held == "constraint" && !pictures)
    throw std::invalid_argument(fmt::format(
        "--held constraint exports shapes (vtk, gmsh, gltf); {} wants natural modes: take none or all",
        arguments.format));
  files::Claims claims;
  if (arguments.format == "matrix-market") {
    files::require_stem(output);
    for (const char* const letter : {"K", "M", "D", "T"})
      claims.add(superelement::matrix_market_name(output, letter));
  } else {
    claims.add(output);
  }
  const Superelement se =
      superelement::read(arguments.file, {.matrices = true,
                                          .inertia = true,
                                          .stiffening = arguments.format == "sid",
                                          .surface = pictures || arguments.format == "flexdata",
                                          .shapes = pictures,
                                          .nodes = arguments.format == "matrix-market"});
  ModeAnalysis modes;
  if (!matrices) {
    modes = arguments.held == "constraint"
                ? superelement::constraint_modes(se)
                : superelement::natural_modes(se,
                                              arguments.held == "all" ? superelement::interface_names(se)
                                                                      : std::vector<std::string>{},
                                              arguments.count);
    if (static_cast<int>(modes.modes.size()) == modes.n_rigid) {
      throw std::invalid_argument(fmt::format(
          "superelement \"{}\" has no elastic mode to write; reduce the part with modes", se.name));
    }
  }
  std::vector<std::filesystem::path> written;
  if (arguments.format == "matrix-market") {
    written = superelement::write_matrix_market(output, se);
  } else if (arguments.format == "dmig") {
    written = {output};
    superelement::write_dmig(written[0], se);
  } else if (arguments.format == "sid") {
    written = {output};
    superelement::write_sid(written[0], se, modes);
  } else if (arguments.format == "flexdata") {
    written = {output};
    superelement::FlexData data = superelement::make_flexdata(se, modes);
    if (arguments.id >= 0) data.id = arguments.id;
    superelement::write_flexdata(written[0], data);
  } else if (arguments.format == "vtk") {
    written = {output};
    superelement::write_vtp(written[0], se, modes);
  } else if (arguments.format == "gltf") {
    written = {output};
    superelement::write_gltf(written[0], se, modes);
  } else {
    written = {output};
    superelement::write_gmsh_views(written[0], se, modes);
  }
  if (!verbosity.quiet) {
    for (const auto& path : written) fmt::print("wrote {}\n", path.string());
  }
  return 0;
}

}  // namespace

terminal::Command export_command() {
  return {
      "export", "write a superelement, results or a mechanism in another program's format",
      [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
        auto arguments = std::make_shared<Arguments>();
        options.argument("FILE", arguments->file, "superelement, results or mechanism file")
            .choice(
                "-f,--format", arguments->format,
                {"matrix-market", "dmig", "sid", "flexdata", "vtk", "gmsh", "gltf", "pvd", "csv", "nodes",
                 "urdf"},
                "what to write; pvd (ParaView), csv and nodes (all nodes of bodies that keep them) take a "
                "results file, urdf a mechanism file, the others a superelement")
            .required()
            .option("-o,--output", arguments->output, "PATH",
                    "file to write (matrix-market: start of the names); default beside FILE")
            .choice("--held", arguments->held, {"none", "all", "constraint"},
                    "modes for sid, flexdata, vtk, gmsh, gltf: of the free body, or with all interfaces "
                    "held; for vtk, gmsh, "
                    "gltf the constraint modes, a unit of each interface direction")
            .option("-n,--count", arguments->count, "N", "at most this many elastic modes")
            .option("--id", arguments->id, "N",
                    "flexdata: id of the body; default 1, or that of the file it came from")
            .option("--frames", arguments->frames, "N",
                    "pvd, nodes: at most about this many times of each run")
            .example("flexura export conrod.se.h5 --format matrix-market", "conrod.K.mtx and conrod.M.mtx")
            .example("flexura export conrod.se.h5 --format sid -n 12",
                     "standard input data with 12 free modes")
            .example("flexura export conrod.se.h5 --format vtk -o modes.vtp", "mode shapes for ParaView")
            .example("flexura export conrod.se.h5 --format gltf -n 6",
                     "six mode shapes that move in any viewer of .glb files")
            .example("flexura export engine.h5 --format pvd", "each run moving in ParaView: engine.RUN.pvd")
            .option("--run", arguments->run, "NAME", "urdf: the run of the mechanism file that is written")
            .example("flexura export arm.toml --format urdf",
                     "a tree of joints as a robot description: arm.urdf")
            .example("flexura export engine.h5 --format csv", "each run as a table: engine.RUN.csv")
            .example("flexura export engine.h5 --format nodes",
                     "where all nodes are and how they turn: engine.RUN.nodes.csv");
        return [arguments, &verbosity] { return run(*arguments, verbosity); };
      }};
}

}  // namespace flexura::app
