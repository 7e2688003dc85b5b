// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "mbs/app/commands.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::app {
namespace {

using superelement::ModeAnalysis;
using superelement::Superelement;

struct Arguments {
  std::string file, output, format, held = "none";
  int count = 30;
};

// "FILE.se.h5" without its endings, for the default name of the output.
std::filesystem::path stem_of(std::filesystem::path file) {
  file.replace_extension();
  if (file.extension() == ".se") file.replace_extension();
  return file;
}

int run(const Arguments& arguments, const terminal::Talk& talk) {
  if (arguments.count < 1)
    throw std::invalid_argument(fmt::format("--count is {}, it must be at least 1", arguments.count));
  const bool pictures = arguments.format == "vtk" || arguments.format == "gmsh";
  const bool matrices = arguments.format == "matrix-market" || arguments.format == "dmig";
  const Superelement se = superelement::read(arguments.file, {.matrices = true,
                                                              .inertia = true,
                                                              .stiffening = arguments.format == "sid",
                                                              .surface = pictures,
                                                              .shapes = pictures});
  const auto output = [&](const char* ending) {
    return arguments.output.empty() ? std::filesystem::path(stem_of(arguments.file).string() + ending)
                                    : std::filesystem::path(arguments.output);
  };
  ModeAnalysis modes;
  if (!matrices) {
    modes = superelement::natural_modes(
        se, arguments.held == "all" ? superelement::interface_names(se) : std::vector<std::string>{},
        arguments.count);
    if (static_cast<int>(modes.modes.size()) == modes.n_rigid) {
      throw std::invalid_argument(fmt::format("superelement \"{}\" has no elastic mode to write", se.name));
    }
  }
  std::vector<std::filesystem::path> written;
  if (arguments.format == "matrix-market") {
    written = superelement::write_matrix_market(output(""), se);
  } else if (arguments.format == "dmig") {
    written = {output(".pch")};
    superelement::write_dmig(written[0], se);
  } else if (arguments.format == "sid") {
    written = {output(".SID_FEM")};
    superelement::write_sid(written[0], se, modes);
  } else if (arguments.format == "flexdata") {
    written = {output(".xml")};
    superelement::write_flexdata(written[0], superelement::make_flexdata(se, modes));
    if (!talk.quiet && !se.load_cases.empty()) {
      fmt::print(stderr,
                 "note: the {} load cases are not written (Reference_FlexData holds no load vectors)\n",
                 se.load_cases.size());
    }
  } else if (arguments.format == "vtk") {
    written = {output(".vtp")};
    superelement::write_vtp(written[0], se, modes);
  } else {
    written = {output(".msh")};
    superelement::write_gmsh_views(written[0], se, modes);
  }
  if (!talk.quiet) {
    for (const auto& path : written) fmt::print("wrote {}\n", path.string());
  }
  return 0;
}

}  // namespace

terminal::Command export_command() {
  return {"export", "write a superelement in another program's format",
          [](terminal::Options& options, const terminal::Talk& talk) -> std::function<int()> {
            auto arguments = std::make_shared<Arguments>();
            options.argument("FILE", arguments->file, "superelement file")
                .choice("-f,--format", arguments->format,
                        {"matrix-market", "dmig", "sid", "flexdata", "vtk", "gmsh"}, "what to write")
                .required()
                .option("-o,--output", arguments->output, "PATH",
                        "file to write (matrix-market: start of the names); default beside FILE")
                .choice("--held", arguments->held, {"none", "all"},
                        "modes for sid, flexdata, vtk, gmsh: of the free body, or with all interfaces held")
                .option("-n,--count", arguments->count, "N", "at most this many elastic modes")
                .example("flexura export conrod.se.h5 --format matrix-market",
                         "conrod.K.mtx and conrod.M.mtx")
                .example("flexura export conrod.se.h5 --format sid -n 12",
                         "standard input data with 12 free modes")
                .example("flexura export conrod.se.h5 --format vtk -o modes.vtp", "mode shapes for ParaView");
            return [arguments, &talk] { return run(*arguments, talk); };
          }};
}

}  // namespace flexura::app
