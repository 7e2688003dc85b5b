// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <stdexcept>

#include "mbs/app/commands.hpp"
#include "mbs/base/files/output.hpp"

namespace flexura::app {
namespace {

/// A commented start.  tests/docs/new_files.sh runs each of them as it stands.
struct Start {
  const char *kind, *file, *text, *next;  // next: the command that takes the file
};

constexpr std::array<Start, 4> starts = {{
    {"part", "part.toml",
     R"(# A part from a CAD file.  All keys: flexura reduce --schema
name = "part"

[geometry]
file = "part.step"              # STEP, IGES, BREP, STL, or a mesh: .inp, .bdf, .msh, .unv

[material.steel]
young = "210 GPa"
poisson = 0.3
density = "7850 kg/m^3"

# Where other bodies take hold.  `flexura reduce --list-faces part.step` prints the faces and tables like these.
[interface.left]
by = "cylinder"
point = ["0 mm", "0 mm", "0 mm"]
axis = [0, 0, 1]
radius = "10 mm"
# tie = "average"               # does not stiffen the bore; without it the bore is rigid

[interface.right]
by = "plane"
point = ["100 mm", "0 mm", "0 mm"]
normal = [1, 0, 0]

[modes]
count = 20
# accuracy = "5 %"              # in place of count: mesh and modes are chosen
damping = 0.01
)",
     "flexura reduce"},
    {"beams", "beams.toml",
     R"(# A part made of beams: nodes and members.  All keys: flexura reduce --schema-beams
name = "beams"

[material.steel]
young = "210 GPa"
poisson = 0.3
density = "7850 kg/m^3"

[section.tube]                  # any other cross-section: flexura section --schema
type = "hollow_circle"
outer_diameter = "30 mm"
inner_diameter = "26 mm"

[node.left]
position = ["0 m", 0, 0]
[node.right]
position = ["1 m", 0, 0]

[member.tube]
nodes = ["left", "right"]
elements = 10

[interface.left]                # at the node of this name
[interface.right]

[modes]
count = 6
damping = 0.01
)",
     "flexura reduce"},
    {"mechanism", "mechanism.toml",
     R"(# A pendulum to start from.  All keys: flexura simulate --schema; all quantities: flexura check mechanism.toml
name = "pendulum"
gravity = [0, 0, "-9.81 m/s^2"]

[parameters]                    # names for formulas; any number below may be a formula of them
length = "1 m"

[ground.marker.pivot]           # a frame fixed in the ground
axis = [0, 1, 0]                # its z axis, about which the hinge turns

[body.bar]
mass = "2 kg"
center = ["length/2", 0, 0]
inertia = ["1e-4 kg*m^2", "2*length^2/12", "2*length^2/12"]
[body.bar.marker.pin]
axis = [0, 1, 0]

# In place of mass, center and inertia a flexible body (flexura new beams; flexura reduce beams.toml):
# superelement = "beams.se.h5"  # its interfaces are markers by their names: "bar.left"

[joint.hinge]
type = "revolute"
from = "ground.pivot"
to = "bar.pin"
angle = "30 deg"                # at the start
# drive = "2*pi*t"              # in place of it: prescribes the angle

# [force.brake]
# type = "joint_spring_damper"
# joint = "hinge"
# damping = 0.1                 # N m s/rad

[solver]
end_time = "2 s"
output_step = "10 ms"

# Several runs with some values changed; all of them stand in one results file.
# [run.short]
# set = ["parameters.length=0.5"]
# [run.long]
)",
     "flexura simulate"},
    {"study", "study.toml",
     R"(# What accuracy costs, measured.  All keys: flexura study --schema
name = "pendulum"
mechanism = "mechanism.toml"
repeats = 1

[axis.tolerance]                # what is chosen, from coarse to fine
key = "solver.tolerance"
values = ["1e-3", "1e-5", "1e-7"]

[reference]                     # what errors are measured against
set = ["solver.tolerance=1e-10"]
[reference.check.tolerance]     # and how well it is known
set = ["solver.tolerance=1e-9"]

[quantity.angle]                # what has to be right
of = "hinge.angle"
norm = "rms"

[want]
accuracy = ["1 %", "0.01 %"]
)",
     "flexura study"},
}};

struct Arguments {
  std::string kind, output;
};

int run(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  for (const Start& start : starts) {
    if (arguments.kind != start.kind) continue;
    const std::filesystem::path output = arguments.output.empty() ? start.file : arguments.output;
    if (std::filesystem::exists(output))
      throw std::invalid_argument(
          fmt::format("{}: is there already; give another name with -o, or remove it", output.string()));
    files::Claims claims;
    claims.add(output);
    files::write_whole(output, start.text);
    if (!verbosity.quiet) fmt::print("wrote {}\nnext: {} {}\n", output.string(), start.next, output.string());
    return 0;
  }
  throw std::invalid_argument(
      fmt::format("there is no start for '{}'; give part, beams, mechanism or study", arguments.kind));
}

}  // namespace

terminal::Command new_command() {
  return {"new", "write a commented file to start from: a part, a mechanism, a study",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto arguments = std::make_shared<Arguments>();
            options.argument("KIND", arguments->kind, "part (CAD), beams, mechanism or study")
                .option("-o,--output", arguments->output, "FILE", "the file (otherwise KIND.toml, here)")
                .example("flexura new mechanism", "a pendulum with comments, which runs as it stands")
                .example("flexura new part -o bracket.toml", "a part file to fill in");
            return [arguments, &verbosity] { return run(*arguments, verbosity); };
          }};
}

}  // namespace flexura::app
