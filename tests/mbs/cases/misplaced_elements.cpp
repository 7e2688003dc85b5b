// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/mbs/cases/text_case.hpp"

/// Elements whose markers stand as they cannot, and sizes out of reach: said, not computed with.
namespace flexura::mbs::cases {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// A shaft 0.1 m beside the origin, and a wheel at the origin; `axis` is that of the shaft's marker.
std::string scene(const std::string& axis, const std::string& force) {
  return fmt::format(R"toml(
gravity = [0, 0, 0]
[ground.marker.far]
position = [0.1, 0, 0]
[body.wheel]
mass = 1
inertia = [0.1, 0.1, 0.1]
[body.shaft]
mass = 1
inertia = [0.1, 0.1, 0.1]
position = [0.1, 0, 0]
[body.shaft.marker.m]
axis = {}
[joint.axle]
type = "revolute"
from = "ground"
to = "wheel"
[joint.free]
type = "planar"
from = "ground.far"
to = "shaft"
[force.f]
{}
)toml",
                     axis, force);
}

const std::string rolling =
    "type = \"rolling_bearing\"\nfrom = \"ground.far\"\nto = \"shaft.m\"\nelements = 8\ndiameter = \"8 mm\"\n"
    "pitch_diameter = \"33 mm\"\n";
const std::string journal =
    "type = \"journal_bearing\"\nfrom = \"ground.far\"\nto = \"shaft.m\"\nradius = \"25 mm\"\nlength = \"20 "
    "mm\"\n"
    "clearance = \"50 um\"\nviscosity = 0.02\n";
const std::string teeth =
    "type = \"involute_mesh\"\nfrom = \"wheel\"\nto = \"shaft.m\"\nmodule = \"2 mm\"\nteeth_1 = 20\nteeth_2 "
    "= 80\n"
    "width = \"10 mm\"\n";

class MisplacedElements : public TextCase {
 protected:
  // What stops it, where it is read or at the start.
  std::string stops(const std::string& text) const {
    try {
      prepared(text);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
};

// A shaft across its bearing gave 2e9 N, one across its wheel "not finite (-nan)".
TEST_F(MisplacedElements, AxesAcrossOneAnotherOrTurnedRoundAreTold) {
  for (const std::string& force : {rolling, journal, teeth}) {
    SCOPED_TRACE(force);
    EXPECT_EQ(stops(scene("[0, 0, 1]", force)), "");
    EXPECT_THAT(stops(scene("[1, 0, 0]", force)),
                AllOf(HasSubstr("\"f\""), HasSubstr("90 deg apart"), HasSubstr("turn one of the markers")));
    EXPECT_THAT(stops(scene("[0, 0, -1]", force)), HasSubstr("180 deg apart"));
  }
}

TEST_F(MisplacedElements, SizesOutOfReachAreRefused) {
  EXPECT_THAT(stops(scene("[0, 0, 1]", rolling + "clearance = \"-1 mm\"\n")), HasSubstr("more than 2 %"));
  EXPECT_EQ(stops(scene("[0, 0, 1]", rolling + "clearance = \"-40 um\"\n")), "");
}

// tanh: with a = L / 2R = 2 the parabola bears 2.6 times too much.
TEST_F(MisplacedElements, ALongJournalBearingIsNoted) {
  const auto notes = [&](const std::string& length) {
    std::string text = scene("[0, 0, 1]", journal);
    text.replace(text.find("20 mm"), 5, length);
    return prepared(text).notes;
  };
  EXPECT_THAT(notes("25 mm"), Not(Contains(HasSubstr("short bearing"))));
  EXPECT_THAT(notes("100 mm"), Contains(AllOf(HasSubstr("4 times as long"), HasSubstr("0.39 of the load"))));
}

TEST_F(MisplacedElements, AForceBetweenEndsThatCoincideIsTold) {
  const std::string line = "type = \"line_force\"\nfrom = \"ground\"\nto = \"wheel\"\nvalue = ";
  EXPECT_THAT(prepared(scene("[0, 0, 1]", line + "100")).notes,
              Contains(AllOf(HasSubstr("\"f\" is 100 N"), HasSubstr("ends coincide"))));
  EXPECT_THAT(prepared(scene("[0, 0, 1]", line + "\"-100*f.length\"")).notes,
              Not(Contains(HasSubstr("ends coincide"))));
  EXPECT_THAT(prepared(scene("[0, 0, 1]",
                             "type = \"spring_damper\"\nfrom = \"ground\"\nto = \"wheel\"\nstiffness = 100\n"
                             "free_length = 0.1\n"))
                  .notes,
              Contains(HasSubstr("ends coincide")));
}

}  // namespace
}  // namespace flexura::mbs::cases
