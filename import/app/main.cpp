// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// flexura-import: turns a robot (URDF) into a folder with a mechanism that runs.  `flexura import`
// hands over to it.
#include <fmt/format.h>

#include <filesystem>

#include "import/model/folder.hpp"
#include "import/urdf/convert.hpp"
#include "mbs/terminal/command_line.hpp"

namespace {

using namespace flexura;

struct Arguments {
  std::string input, output, base = "fixed";
  std::vector<std::string> packages;
  bool force = false, no_stops = false;
};

std::string ending_of(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending;
}

void report(const import::Mechanism& mechanism, const std::filesystem::path& folder, const terminal::Talk& talk) {
  if (talk.quiet) return;
  std::size_t joints = 0;
  for (const import::Element& e : mechanism.elements) joints += e.table == "joint" ? 1 : 0;
  for (const std::string& note : mechanism.notes) fmt::print(stderr, "note: {}\n", note);
  fmt::print("{} bodies, {} joints, {} other elements\n", mechanism.bodies.size(), joints, mechanism.elements.size() - joints);
  fmt::print("mechanism {}\n", (folder / "mechanism.toml").string());
}

int import_file(const Arguments& a, const terminal::Talk& talk) {
  const std::string ending = ending_of(a.input);
  if (ending == ".xacro")
    throw std::invalid_argument(a.input + ": is a xacro template; expand it first: xacro robot.xacro > robot.urdf");
  if (ending != ".urdf")
    throw std::invalid_argument(a.input + ": is not of a kind that is imported; robots (.urdf) are");
  const std::filesystem::path folder = a.output.empty() ? std::filesystem::path(a.input).stem() : std::filesystem::path(a.output);
  const import::Mechanism mechanism =
      import::urdf::to_mechanism(import::urdf::read_robot(a.input), {.floating_base = a.base == "floating",
                                                                    .stops = !a.no_stops,
                                                                    .packages = a.packages});
  import::write_folder(folder, mechanism, {}, a.force);
  report(mechanism, folder, talk);
  return 0;
}

std::function<int()> declare(terminal::Options& options, const terminal::Talk& talk) {
  const auto a = std::make_shared<Arguments>();
  options.argument("FILE", a->input, "robot (.urdf)")
      .option("-o,--output", a->output, "FOLDER", "folder to write, made where it is not there (default: the file's name)")
      .flag("--force", a->force, "replace files of the folder that are there already")
      .choice("--base", a->base, {"fixed", "floating"}, "whether the root link stands on the ground or floats free (default: fixed)")
      .flag("--no-stops", a->no_stops, "leave the limits of the joints' travel out")
      .option("--package", a->packages, "NAME=FOLDER", "where package://NAME/ of the meshes lies")
      .example("flexura import robot.urdf -o robot", "then: flexura simulate robot/mechanism.toml");
  return [a, &talk] { return import_file(*a, talk); };
}

}  // namespace

int main(int argc, char** argv) {
  return terminal::run({.name = "flexura import", .summary = "make a mechanism of a robot", .declare = declare},
                       FLEXURA_VERSION, argc, argv);
}
