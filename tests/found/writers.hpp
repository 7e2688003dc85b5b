// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/beam/input_texts.hpp"
#include "tests/mbs/superelement/box_beam.hpp"

// Every command that writes, and inputs of every kind for them.
namespace flexura::test {

inline const std::string kMechanism = R"toml(
[table.lift]
file = "lift.txt"
[body.rod]
superelement = "beam.se.h5"
[joint.hinge]
type = "revolute"
from = "ground"
to = "rod.left"
[force.push]
type = "joint_force"
joint = "hinge"
value = "lift(t)"
[input]
u = "N m"
[solver]
end_time = "10 ms"
output_step = "1 ms"
store_states = true
)toml";

/// A folder with one input of every kind.
class Outputs : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    const Folder& f = *folder_;
    superelement::write(f / "beam.se.h5", superelement::testing::make_box_beam());
    f.write("lift.txt", "0 0\n1 1\n");
    f.write("m.toml", replaced(kMechanism, "[input]\nu = \"N m\"\n", ""));
    f.write("channel.toml", beam::testing::kSteelText + beam::testing::kChannelText);
    f.write("boom.toml", R"([section.profile]
type = "file"
file = "channel.section"
[node.root]
position = [0, 0, 0]
[node.tip]
position = [6, 0, 0]
[member.boom]
nodes = ["root", "tip"]
[interface.root]
[load.tip]
force = [0, 0, -100]
node = "tip"
[modes]
count = 4
)");
    f.write("study.toml", "mechanism = \"m.toml\"\n[choice.a]\n[quantity.x]\nof = \"hinge.angle\"\n");
    f.write("report.json", R"({"title": "a report", "sections": []})");
    ok({"section", f / "channel.toml"});
    ok({"assemble", f / "m.toml", "--save-state", f / "state.json"});
    ok({"simulate", f / "m.toml", "-o", f / "r.h5", "-q"});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static void ok(const std::vector<std::string>& words) {
    const Outcome outcome = run("flexura", words);
    ASSERT_EQ(outcome.exit_code, 0) << words[0] << ": " << outcome.err;
  }

  static inline Folder* folder_ = nullptr;
};

/// A command that writes.  OUT stands for the output as it is named; `ending` is added where the program adds
/// it.
struct Writer {
  std::string name;
  std::vector<std::string> words, inputs;
  std::string out = "out", ending = "";
  bool is_quick = true;
};

inline std::vector<Writer> writers() {
  return {{"simulate",
           {"simulate", "m.toml", "-o", "OUT", "-q", "--from-state", "state.json"},
           {"m.toml", "beam.se.h5", "lift.txt", "state.json"}},
          {"save_state",
           {"simulate", "m.toml", "-q", "-o", "other.h5", "--save-state", "OUT"},
           {"m.toml", "beam.se.h5", "lift.txt"}},
          {"simulate_csv",
           {"simulate", "m.toml", "-o", "OUT", "-q", "--csv"},
           {"m.toml", "beam.se.h5"},
           "out.h5",
           ".run.csv"},
          {"assemble", {"assemble", "m.toml", "--save-state", "OUT", "-q"}, {"m.toml", "beam.se.h5"}},
          {"statics", {"statics", "m.toml", "--save-state", "OUT", "-q"}, {"m.toml", "lift.txt"}},
          {"linearize",
           {"linearize", "m.toml", "--frozen", "-o", "OUT", "-q"},
           {"m.toml", "beam.se.h5"},
           "out.m"},
          {"linearize_h5", {"linearize", "m.toml", "--frozen", "-o", "OUT", "-q"}, {"m.toml"}, "out.h5"},
          {"linearize_mtx",
           {"linearize", "m.toml", "--frozen", "-o", "OUT.mtx", "-q"},
           {"m.toml"},
           "out",
           "_A.mtx"},
          {"eigen", {"eigen", "m.toml", "--frozen", "--pictures", "OUT", "-q"}, {"m.toml", "beam.se.h5"}},
          {"outputs", {"outputs", "m.toml", "r.h5", "-o", "OUT", "-q"}, {"r.h5", "m.toml", "beam.se.h5"}},
          {"spectrum", {"spectrum", "r.h5", "--quantity", "energy.kinetic", "-o", "OUT", "-q"}, {"r.h5"}},
          {"view", {"view", "r.h5", "-o", "OUT", "-q"}, {"r.h5", "beam.se.h5"}},
          {"modes", {"modes", "beam.se.h5", "--html", "OUT", "-q"}, {"beam.se.h5"}},
          {"report", {"report", "beam.se.h5", "-o", "OUT", "-q"}, {"beam.se.h5"}},
          {"report_json", {"report", "report.json", "-o", "OUT", "-q"}, {"report.json"}},
          {"export_vtk", {"export", "beam.se.h5", "-f", "vtk", "-o", "OUT", "-q"}, {"beam.se.h5"}},
          {"export_dmig", {"export", "beam.se.h5", "-f", "dmig", "-o", "OUT", "-q"}, {"beam.se.h5"}},
          {"export_sid", {"export", "beam.se.h5", "-f", "sid", "-o", "OUT", "-q"}, {"beam.se.h5"}},
          {"export_flexdata", {"export", "beam.se.h5", "-f", "flexdata", "-o", "OUT", "-q"}, {"beam.se.h5"}},
          {"export_gmsh", {"export", "beam.se.h5", "-f", "gmsh", "-o", "OUT", "-q"}, {"beam.se.h5"}},
          {"export_gltf", {"export", "beam.se.h5", "-f", "gltf", "-o", "OUT", "-q"}, {"beam.se.h5"}},
          {"export_mtx",
           {"export", "beam.se.h5", "-f", "matrix-market", "-o", "OUT", "-q"},
           {"beam.se.h5"},
           "out",
           ".K.mtx"},
          {"export_csv", {"export", "r.h5", "-f", "csv", "-o", "OUT", "-q"}, {"r.h5"}, "out", ".run.csv"},
          {"export_pvd", {"export", "r.h5", "-f", "pvd", "-o", "OUT", "-q"}, {"r.h5"}, "out", ".run.pvd"},
          {"study",
           {"study", "study.toml", "-o", "OUT"},
           {"study.toml", "m.toml", "lift.txt", "beam.se.h5"},
           "out",
           ".html",
           false},
          {"section", {"section", "channel.toml", "-o", "OUT", "-q"}, {"channel.toml"}},
          {"section_svg",
           {"section", "channel.toml", "-o", "other.section", "--svg", "OUT", "-q"},
           {"channel.toml"}},
          {"reduce", {"reduce", "boom.toml", "-o", "OUT", "-q"}, {"boom.toml", "channel.section"}},
          {"reduce_report",
           {"reduce", "boom.toml", "-o", "other.se.h5", "--report", "OUT", "-q"},
           {"boom.toml", "channel.section"}},
          {"reduce_statics",
           {"reduce", "boom.toml", "--statics", "--report", "OUT", "-q"},
           {"boom.toml", "channel.section"}}};
}

}  // namespace flexura::test
