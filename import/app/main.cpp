// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// flexura-import: turns a robot (URDF, MJCF, SDF) or a CAD assembly (STEP) into a folder with a mechanism that runs.  `flexura import`
// hands over to it.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "import/app/ask.hpp"
#include "import/app/robot.hpp"
#include "import/app/tree_robot.hpp"
#include "import/cad/joints/build.hpp"
#include "import/model/findings.hpp"
#include "import/model/folder.hpp"
#include "import/page/page.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/documents/units.hpp"
#include "mbs/base/terminal/command_line.hpp"
#include "mbs/base/terminal/terminal.hpp"

namespace {

namespace fs = std::filesystem;
using namespace flexura;

struct Arguments {
  std::string input, output, base, joints, ground, density, clearance, time_limit, massless, controllers,
      xacro;
  std::vector<std::string> packages;
  bool force = false, no_stops = false, strict = false, contacts = false;
};

// Names that are others here than in the file.
void print_names(const import::Mechanism& mechanism, const fs::path& folder) {
  constexpr std::size_t most = 20;
  if (mechanism.renamed.empty()) return;
  terminal::Table table({{"of the file", terminal::Align::left}, {"name here", terminal::Align::left}});
  for (std::size_t i = 0; i < std::min(most, mechanism.renamed.size()); ++i)
    table.add_row({input::shown_text(mechanism.renamed[i].first), mechanism.renamed[i].second});
  fmt::print("{}", table.text());
  if (mechanism.renamed.size() > most)
    fmt::print("... and {} more, at the head of {}\n", mechanism.renamed.size() - most,
               (folder / "mechanism.toml").string());
}

void report(const import::Mechanism& mechanism, const std::filesystem::path& folder,
            const terminal::Verbosity& verbosity) {
  if (verbosity.quiet) return;
  std::size_t joints = 0;
  for (const import::Element& e : mechanism.elements) joints += e.table == "joint" ? 1 : 0;
  for (const std::string& note : mechanism.notes) terminal::say(stderr, "note: " + note);
  print_names(mechanism, folder);
  if (!mechanism.note_count.empty()) terminal::say(stderr, mechanism.note_count);
  fmt::print("{} bodies, {} joints, {} other elements\n", mechanism.bodies.size(), joints,
             mechanism.elements.size() - joints);
  fmt::print("mechanism {}\n", (folder / "mechanism.toml").string());
}

// What one kind of file knows and the other does not is refused, not passed over.
void refuse_options_of_the_other_kind(const Arguments& a, bool is_robot) {
  const auto refuse = [&](bool given, const char* option, const char* whose) {
    if (given)
      throw std::invalid_argument(
          fmt::format("{}: {} is for {}, which this is not: leave it out", a.input, option, whose));
  };
  if (is_robot) {
    refuse(!a.joints.empty(), "--joints", "assemblies");
    refuse(!a.ground.empty(), "--ground", "assemblies");
    refuse(!a.clearance.empty(), "--clearance", "assemblies");
    refuse(!a.time_limit.empty(), "--time-limit", "assemblies");
  } else {
    refuse(!a.base.empty(), "--base", "robots");
    refuse(a.no_stops, "--no-stops", "robots");
    refuse(a.strict, "--strict", "robots");
    refuse(a.contacts, "--contacts", "robots");
    refuse(!a.massless.empty(), "--massless", "robots");
    refuse(!a.controllers.empty(), "--controllers", "robots");
    refuse(!a.xacro.empty(), "--xacro", "robots");
    refuse(!a.packages.empty(), "--package", "robots");
  }
}

// A MJCF or SDF says by itself what its bodies weigh and which motors it has.
void refuse_options_of_urdf(const Arguments& a) {
  if (a.contacts)
    throw std::invalid_argument(a.input + ": --contacts is for URDF, which this is not: leave it out");
  for (const auto& [text, option] : {std::pair(&a.massless, "--massless"),
                                     {&a.controllers, "--controllers"},
                                     {&a.density, "--density"},
                                     {&a.xacro, "--xacro"}})
    if (!text->empty())
      throw std::invalid_argument(
          fmt::format("{}: {} is for URDF, which this is not: leave it out", a.input, option));
}

double quantity(const std::string& text, const char* option, const input::Dimension& dimension,
                double otherwise) {
  if (text.empty()) return otherwise;
  double value = 0.0;
  try {
    value = input::parse_quantity(text, dimension);
  } catch (const std::invalid_argument& why) {
    throw std::invalid_argument(fmt::format("{} {}: {}", option, text, why.what()));
  }
  if (!(value > 0.0)) throw std::invalid_argument(fmt::format("{} {}: must be positive", option, text));
  return value;
}

void print_proposal(const import::cad::Built& built, const terminal::Verbosity& verbosity) {
  if (verbosity.quiet) return;
  terminal::Table table({{"joint", terminal::Align::left},
                         {"type", terminal::Align::left},
                         {"confidence", terminal::Align::left},
                         {"redundant"}});
  std::size_t i = 0;
  for (const import::Element& e : built.mechanism.elements) {
    if (e.table != "joint" || e.name == built.mechanism.elements.front().name) continue;
    const import::cad::ProposedJoint& joint = built.proposal.joints[i++];
    const std::string& type = e.lines.front().second;
    table.add_row({e.name, type.substr(1, type.size() - 2), name_of(joint.confidence),
                   fmt::format("{}", joint.redundant)});
  }
  if (i > 0) fmt::print("{}", table.text());
  fmt::print("degrees of freedom: {}\n",
             built.proposal.freedom
                 ? fmt::format("{}", *built.proposal.freedom)
                 : "unknown, not counted for more than 400 bodies that move (flexura check)");
}

// The mechanism is there and runs: a build without pages is no reason to fail.
void write_page(const fs::path& file, const std::function<void()>& write, const char* what,
                const terminal::Verbosity& verbosity) {
  try {
    write();
    if (!verbosity.quiet) fmt::print("page      {}: {}\n", file.string(), what);
  } catch (const std::runtime_error& why) {
    terminal::say(stderr, fmt::format("note: no page: {}", why.what()));
  }
}

int write_robot(const Arguments& a, const import::ReadRobot& robot, const fs::path& folder,
                const terminal::Verbosity& verbosity) {
  const fs::path page = folder / "robot.html";
  import::write_folder(folder, robot.mechanism, robot.texts, a.force, {page});
  report(robot.mechanism, folder, verbosity);
  write_page(
      page, [&] { import::write_robot_page(page, robot); }, "what was found", verbosity);
  return 0;
}

int import_robot(const Arguments& a, const std::filesystem::path& folder,
                 const terminal::Verbosity& verbosity) {
  using import::urdf::Massless;
  const import::ReadRobot robot =
      import::read_robot(a.input,
                         {.floating_base = a.base == "floating",
                          .stops = !a.no_stops,
                          .controllers = a.controllers == "pd",
                          .contacts = a.contacts,
                          .massless = a.massless == "refuse"       ? Massless::refuse
                                      : a.massless == "kinematics" ? Massless::kinematics
                                                                   : Massless::derive,
                          .density = quantity(a.density, "--density", input::dim::density, 1000.0),
                          .packages = a.packages},
                         a.strict, a.xacro == "run");
  return write_robot(a, robot, folder, verbosity);
}

int import_tree(const Arguments& a, import::TreeFormat format, const fs::path& folder,
                const terminal::Verbosity& verbosity) {
  const import::ReadRobot robot =
      import::read_tree(a.input, format,
                        {.floating_base = a.base.empty() ? std::nullopt : std::optional(a.base == "floating"),
                         .stops = !a.no_stops,
                         .packages = a.packages},
                        a.strict);
  return write_robot(a, robot, folder, verbosity);
}

// What overlaps goes into the notes as well; where it cannot be sought, that does.
std::vector<import::cad::Overlap> overlaps_of(const std::string& file, const import::cad::Assembly& assembly,
                                              double clearance, double limit, import::Mechanism& mechanism) {
  try {
    auto overlaps = import::cad::find_overlaps(file, assembly, clearance, limit);
    for (const import::cad::Overlap& o : overlaps)
      mechanism.notes.push_back(import::overlap_text(o, mechanism.bodies[static_cast<std::size_t>(o.a)].name,
                                                     mechanism.bodies[static_cast<std::size_t>(o.b)].name));
    return overlaps;
  } catch (const std::runtime_error& why) {
    mechanism.notes.emplace_back(why.what());
    return {};
  }
}

int import_assembly(const Arguments& a, const std::filesystem::path& folder,
                    const terminal::Verbosity& verbosity) {
  import::cad::BuildOptions options{
      .propose = {.clearance = quantity(a.clearance, "--clearance", input::dim::length, 2e-4),
                  .ground = a.ground},
      .joints = a.joints != "none",
      .density = quantity(a.density, "--density", input::dim::density, 7850.0)};
  if (a.joints == "ask")
    options.decide = [](const auto& assembly, import::cad::Proposal& proposal, const auto& names) {
      import::ask_about_joints(assembly, proposal, names, std::cin, std::cout);
    };
  const double limit = quantity(a.time_limit, "--time-limit", input::dim::time, 600.0);
  const import::cad::Assembly assembly = import::cad::read_assembly(a.input, limit);
  import::cad::Built built =
      import::cad::build(assembly, std::filesystem::path(a.input).stem().string(), options);
  // The mechanism does not need it: shapes of long threads take OpenCASCADE minutes.
  constexpr double most_for_overlaps = 60.0;
  const double overlap_limit = a.time_limit.empty() ? std::min(limit, most_for_overlaps) : limit;
  const auto overlaps =
      overlaps_of(a.input, assembly, options.propose.clearance, overlap_limit, built.mechanism);
  const fs::path page = folder / "assembly.html";
  import::write_folder(folder, built.mechanism, built.texts, a.force, {page});
  if (options.joints) print_proposal(built, verbosity);
  report(built.mechanism, folder, verbosity);
  write_page(
      page, [&] { view::write_parts_page(page, import::page_of(assembly, built, overlaps)); },
      "the joints, to be looked at and changed", verbosity);
  return 0;
}

int import_file(const Arguments& a, const terminal::Verbosity& verbosity) {
  const std::string ending = import::ending_of(a.input);
  const auto tree = import::tree_format(a.input);
  const bool is_robot = tree || ending == ".urdf" || ending == ".xacro" || ending == ".xml";
  if (!is_robot && ending != ".step" && ending != ".stp")
    throw std::invalid_argument(
        a.input +
        ": is not of a kind that is imported; name a robot (.urdf, .xacro, .xml, .mjcf, .sdf, .world) or "
        "an assembly (.step, .stp)");
  refuse_options_of_the_other_kind(a, is_robot);
  if (tree) refuse_options_of_urdf(a);
  fs::path folder = a.output;
  if (a.output.empty()) {  // robot.urdf.xacro: "robot"
    folder = fs::path(a.input).stem();
    if (import::ending_of(folder) == ".urdf") folder = folder.stem();
  }
  if (tree) return import_tree(a, *tree, folder, verbosity);
  return is_robot ? import_robot(a, folder, verbosity) : import_assembly(a, folder, verbosity);
}

std::function<int()> declare(terminal::Options& options, const terminal::Verbosity& verbosity) {
  const auto a = std::make_shared<Arguments>();
  options
      .argument("FILE", a->input,
                "robot (.urdf, .xacro; .xml or .mjcf of MuJoCo; .sdf or .world of Gazebo) or assembly "
                "(.step, .stp)")
      .option("-o,--output", a->output, "FOLDER",
              "folder to write, made where it is not there (default: the file's name)")
      .flag("--force", a->force, "replace files of the folder that are there already")
      .choice("--base", a->base, {"fixed", "floating"},
              "robots: whether the root link stands on the ground or floats free (default: fixed; of SDF "
              "floating)")
      .flag("--no-stops", a->no_stops, "robots: leave the limits of the joints' travel out")
      .option("--package", a->packages, "NAME=FOLDER", "robots: where package://NAME/ or model://NAME/ lies")
      .choice("--joints", a->joints, {"propose", "ask", "none"},
              "assemblies: propose joints from the geometry, ask about each of them, or leave the bodies "
              "free (default: propose)")
      .option("--ground", a->ground, "BODY",
              "assemblies: the body that stands still (default: the one with the largest box)")
      .option("--clearance", a->clearance, "LENGTH",
              "assemblies: greatest gap between faces that touch (default: 0.2 mm)")
      .option(
          "--density", a->density, "DENSITY",
          "assemblies: of parts that have none in the file (default: 7850 kg/m^3); robots: of shapes that "
          "give a link its inertia (default: 1000 kg/m^3)")
      .choice(
          "--massless", a->massless, {"derive", "kinematics", "refuse"},
          "robots: links that move without inertia get that of their shapes, have their joints driven, or "
          "are refused (default: derive; kinematics where there are no shapes)")
      .flag("--contacts", a->contacts,
            "robots: collision shapes of links that move touch the floor, with Gazebo's mu1, kp and kd")
      .choice("--controllers", a->controllers, {"none", "pd"},
              "robots: motors are inputs, or follow a target by a PD law (default: none)")
      .choice("--xacro", a->xacro, {"plain", "run"},
              "robots: templates are expanded by the program xacro where their formulas are arithmetic, or "
              "whatever Python is in them (default: plain)")
      .flag("--strict", a->strict, "robots: refuse what would be repaired")
      .option("--time-limit", a->time_limit, "TIME",
              "assemblies: give the reading up after this time (default: 600 s)")
      .example("flexura import robot.urdf -o robot", "then: flexura simulate robot/mechanism.toml")
      .example("flexura import engine.step -o engine",
               "bodies, joints from their geometry, part files for flexura reduce");
  return [a, &verbosity] {
    try {
      return import_file(*a, verbosity);
    } catch (const import::Faults& faults) {
      if (faults.all().empty()) throw;
      terminal::say(stderr, fmt::format("error: {}", faults.what()));
      constexpr std::size_t most = 200;
      for (std::size_t i = 0; i < std::min(most, faults.all().size()); ++i)
        terminal::say(stderr, "  " + input::shown_message(faults.all()[i]));
      if (faults.all().size() > most)
        terminal::say(stderr, fmt::format("  ... and {} more", faults.all().size() - most));
      return 2;
    }
  };
}

}  // namespace

int main(int argc, char** argv) {
  return terminal::run({.name = "flexura import",
                        .summary = "make a mechanism of a robot or a CAD assembly",
                        .declare = declare},
                       FLEXURA_VERSION, argc, argv);
}
