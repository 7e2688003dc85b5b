// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What a run says of the error of its section forces.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

const std::string kRod = R"toml(
stiffening = true
[material.m]
young = "210 GPa"
poisson = 0.3
density = 7850
[section.s]
type = "rectangle"
width = 0.05
height = 0.03
[node.a]
position = [0, 0, 0]
[node.b]
position = [1, 0, 0]
[member.r]
nodes = ["a", "b"]
elements = 8
[interface.a]
[interface.b]
)toml";

std::string turning_rod(const std::string& keys) {
  return fmt::format(
      "gravity = [0, 0, -9.81]\n[ground.marker.o]\naxis = [0, 0, 1]\n[body.b]\nsuperelement = "
      "\"rod.se.h5\"\n{}[body.b.marker.c]\non = \"a\"\naxis = [0, 0, 1]\n[body.b.section_point.h]\nmember = "
      "\"r\"\nshare = 0.5\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground.o\"\nto = \"b.c\"\ndrive = \"20 * "
      "t\"\n[solver]\nend_time = 40\noutput_step = 0.4\ninitial_deformation = "
      "\"quasi_static\"\n[output]\nquantities = [\"b.h.N\", \"b.h.M_y\"]\n",
      keys);
}

std::string said_of(const std::string& keys) {
  const Folder folder;
  const auto part = folder.write("rod.toml", kRod), scene = folder.write("m.toml", turning_rod(keys));
  EXPECT_EQ(run("flexura", {"reduce", part.string(), "-q", "-o", (folder / "rod.se.h5").string()}).exit_code,
            0);
  const Outcome out = run("flexura", {"simulate", scene.string(), "-o", (folder / "m.h5").string()});
  EXPECT_EQ(out.exit_code, 0) << out.err;
  return out.out;
}

// Modes left out follow loads that change slowly, and section forces have what they bear: in a steady turn nothing is missing
// but what the rod's tension, which static response does not know, takes from its bending moment, 1.1 %, and what the estimate
// makes ring at the start, less over so long a time.
TEST(SectionForces, OfModesThatFollowTheirLoadsAreInTheRun) {
  for (const std::string keys : {"fidelity = \"static\"\n",
                                 "fidelity = \"modal-stiffened\"\nmodes = 2\nframe = "
                                 "\"joint_fixed\"\n"}) {
    const std::string said = said_of(keys);
    std::smatch figure;
    ASSERT_TRUE(std::regex_search(said, figure, std::regex(R"((\S+) %  modes left out of b)"))) << said;
    EXPECT_LT(std::stod(figure[1]), 2.0) << said;
  }
}

TEST(SectionForces, OfOneWayBodiesHaveALineOfTheirOwn) {
  EXPECT_THAT(said_of("fidelity = \"ked\"\n"), HasSubstr("section forces of b: a one-way body's vibration"));
}

}  // namespace
}  // namespace flexura::test
