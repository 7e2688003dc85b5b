// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>

#include "mbs/mechanism/range/linear_range.hpp"
#include "tests/mbs/cases/text_case.hpp"

/// Planar beams from files: what they need of the section, what they refuse, and the run of the spatial one.
namespace flexura::mbs::beams {
namespace {

using Eigen::VectorXd;

class PlanarFile : public cases::TextCase {
 protected:
  static std::string cable(const std::string& fidelity, const std::string& section, const std::string& y_axis,
                           double tolerance = 1e-4) {
    return fmt::format(R"toml(
gravity = [0, 0, -9.81]
[body.cable]
fidelity = "{}"
[body.cable.beam]
to = [2, 0, 0]
y_axis = {}
elements = 16
{}
[joint.hook]
type = "revolute"
from = "ground.hook"
to = "cable.hook"
[ground.marker.hook]
axis = [0, 1, 0]
[body.cable.marker.hook]
on = "root"
axis = [0, 1, 0]
[measure.x]
type = "position"
from = "ground"
to = "cable.tip"
direction = [1, 0, 0]
[measure.z]
type = "position"
from = "ground"
to = "cable.tip"
direction = [0, 0, 1]
[solver]
end_time = 0.5
output_step = 0.1
tolerance = {}
)toml",
                       fidelity, y_axis, section, tolerance);
  }
};

const std::string kCable =
    "EA = 1e6\nEI_y = 1\nEI_z = 1\nmass_per_length = 1\nrho_I_y = 1e-6\nrho_I_z = 1e-6";
const std::string kAll = kCable + "\nGA_y = 4e5\nGA_z = 4e5\nGI_t = 1";
const std::string kPlanar = "\nplanar = true";

// The axes of the section are others, its constants are not: one motion, to what both runs' tolerances leave.
TEST_F(PlanarFile, MovesAsTheSpatialBeam) {
  for (const char* const fidelity : {"cable", "rod", "beam"}) {
    SCOPED_TRACE(fidelity);
    const auto planar =
        cases::simulate(prepared(cable(fidelity, kAll + kPlanar, "[0, 0, 1]", 1e-6)), {"x", "z"});
    const auto spatial = cases::simulate(prepared(cable(fidelity, kAll, "[0, 1, 0]", 1e-6)), {"x", "z"});
    for (std::size_t i = 0; i < planar.t.size(); ++i)
      EXPECT_LT((planar.values[i] - spatial.values[i]).norm(), 2e-5) << planar.t[i];
    EXPECT_LT(std::abs(planar.result.energy.relative_error()),
              1e-4);  // stretch and shear are held to what they displace
  }
}

TEST_F(PlanarFile, NeedsOfTheSectionWhatIsInItsPlane) {
  const std::string none = "planar = true\nmass_per_length = 1\n";
  EXPECT_NO_THROW(prepared(cable("cable", none + "EA = 1e6", "[0, 0, 1]")));
  EXPECT_NO_THROW(prepared(cable("rod", none + "EI_z = 1\nrho_I_z = 1e-6", "[0, 0, 1]")));
  EXPECT_NO_THROW(
      prepared(cable("beam", none + "EA = 1e6\nGA_y = 4e5\nEI_z = 1\nrho_I_z = 1e-6", "[0, 0, 1]")));
  EXPECT_NO_THROW(prepared(cable("ancf", none + "EA = 1e6\nEI_z = 1", "[0, 0, 1]")));
  const std::string message =
      refusal(cable("beam", none + "EA = 1e6\nEI_z = 1\nrho_I_z = 1e-6", "[0, 0, 1]"));
  EXPECT_NE(message.find("has no GA_y"), std::string::npos) << message;
}

TEST_F(PlanarFile, RefusesWhatLeavesThePlane) {
  const auto says = [&](const std::string& fidelity, const std::string& section, const std::string& words) {
    const std::string message = refusal(cable(fidelity, section, "[0, 0, 1]"));
    EXPECT_NE(message.find(words), std::string::npos) << message;
  };
  says("segments", kAll + kPlanar, "this fidelity has beams in space alone");
  says("beam", kAll + kPlanar + "\ncurvature = [0, 0.1, 0]", "keep the third number alone");
  const std::string matrices =
      "planar = true\nmass = [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,2e-6,0,0],[0,0,0,0,1e-6,0],"
      "[0,0,0,0,0,1e-6]]\nstiffness = [[1e6,0,0,0,0,0],[0,4e5,0,0,0,0],[0,0,4e5,0,0,0],[0,0,0,1,0,{0}],"
      "[0,0,0,0,1,0],[0,0,0,{0},0,1]]";
  says("beam", fmt::format(fmt::runtime(matrices), "0.3"), "couples the plane with what is across it");
  EXPECT_NO_THROW(prepared(cable("beam", fmt::format(fmt::runtime(matrices), "0"), "[0, 0, 1]")));
}

// y_axis as it is without being given: the plane is level, and gravity is across it.
TEST_F(PlanarFile, TellsOfGravityAcrossItsPlane) {
  for (const bool level : {true, false}) {
    const PreparedMechanism p = prepared(cable("cable", kCable + kPlanar, level ? "[0, 1, 0]" : "[0, 0, 1]"));
    LinearRange range(*p.mechanism);
    range.observe(p.state);
    const std::vector<std::string> told = range.sentences();
    ASSERT_EQ(told.size(), level ? 1u : 0u);
    if (level)
      EXPECT_NE(told[0].find("where gravity has 9.81 m/s^2 at t = 0 s"), std::string::npos) << told[0];
  }
}

// A force across is carried without a deflection: what that leaves out is not judged, and is no 0 (a tip force of 5 N moved a
// beam of EI 10 N m^2 and 1 m by nothing in place of F l^3 / 3 EI = 0.17 m, with an estimated error of 0.6 %).
TEST_F(PlanarFile, BendingAcrossThePlaneIsUnknown) {
  for (const bool planar : {true, false}) {
    const PreparedMechanism p =
        prepared(cable("cable", planar ? kCable + kPlanar : kCable, planar ? "[0, 0, 1]" : "[0, 1, 0]"));
    EXPECT_EQ(std::ranges::count(p.file.blind_spots, "plane", &BlindSpot::kind), planar ? 1 : 0);
  }
}

}  // namespace
}  // namespace flexura::mbs::beams
