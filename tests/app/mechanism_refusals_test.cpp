// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Bad mechanisms and damaged superelements: one clear message, exit code 2, no results file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const char* const kFourBar = R"(name = "four-bar"
[ground.marker.left]
axis = [0, 0, 1]
[ground.marker.right]
position = [2, 0, 0]
axis = [0, 0, 1]
[body.crank]
mass = 1
inertia = [0.1, 0.1, 0.1]
marker.a = { position = [0, 0, 0] }
marker.b = { position = [1, 0, 0] }
[body.coupler]
mass = 1
inertia = [0.1, 0.1, 0.1]
marker.a = { position = [0, 0, 0] }
marker.b = { position = [2, 0, 0] }
[body.rocker]
mass = 1
inertia = [0.1, 0.1, 0.1]
marker.a = { position = [0, 0, 0] }
marker.b = { position = [1.5, 0, 0] }
[joint.ground_left]
type = "revolute"
from = "ground.left"
to = "crank.a"
angle = "70 deg"
[joint.left]
type = "revolute"
from = "crank.b"
to = "coupler.a"
[joint.right]
type = "revolute"
from = "coupler.b"
to = "rocker.b"
[joint.ground_right]
type = "revolute"
from = "ground.right"
to = "rocker.a"
angle = "80 deg"
[solver]
end_time = 0.1
)";

class BadMechanism : public testing::Test {
 protected:
  std::string refusal(const std::string& text, int exit_code = 2) {
    const std::filesystem::path file = folder.write("bar.toml", text);
    const Outcome outcome = run("flexura", {"simulate", file.string(), "-o", (folder / "bar.h5").string()});
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(testing::StartsWith("error: "), Not(HasSubstr("HDF5-DIAG"))));
    EXPECT_FALSE(std::filesystem::exists(folder / "bar.h5"));
    return outcome.err;
  }

  Folder folder;
};

TEST_F(BadMechanism, TheGoodOneRuns) {
  const std::filesystem::path file = folder.write("bar.toml", kFourBar);
  const Outcome outcome = run("flexura", {"simulate", file.string(), "-o", (folder / "bar.h5").string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "bar.h5"));
}

TEST_F(BadMechanism, UnknownBodyInAJointGetsASuggestion) {
  EXPECT_THAT(
      refusal(replaced(kFourBar, "from = \"coupler.b\"", "from = \"cuopler.b\"")),
      AllOf(HasSubstr("joint.right.from"), HasSubstr("cuopler"), HasSubstr("did you mean \"coupler")));
}

TEST_F(BadMechanism, BarsThatCannotMeetAreRefusedByTheConstraintThatStaysOpen) {
  EXPECT_THAT(refusal(replaced(kFourBar, "position = [2, 0, 0]\naxis", "position = [9, 0, 0]\naxis")),
              AllOf(HasSubstr("cannot be assembled"), HasSubstr("right")));
}

TEST_F(BadMechanism, AQuaternionOfZerosIsNoRotation) {
  const std::string start = replaced(kFourBar, "type = \"revolute\"\nfrom = \"crank.b\"",
                                     "type = \"spherical\"\nqw = 0\nqx = 0\nfrom = \"crank.b\"");
  EXPECT_THAT(refusal(start),
              HasSubstr("joint.left.qw = 0: qw, qx, qy and qz are all zero, which is no rotation"));
}

TEST_F(BadMechanism, NegativeMassIsRefused) {
  EXPECT_THAT(refusal(replaced(kFourBar, "mass = 1", "mass = -1")),
              AllOf(HasSubstr("body.crank.mass"), HasSubstr("-1")));
}

TEST_F(BadMechanism, DamagedSuperelementsAreRefused) {
  const std::string source = FLEXURA_SOURCE_DIR;
  const std::filesystem::path good = folder / "rod.se.h5";
  const Outcome reduced =
      run("flexura-reduce", {source + "/cases/steam_engine/conrod.toml", "-o", good.string(), "--mesh-size",
                             "25 mm", "--set", "mesh.elements_per_circle=6", "--modes", "2"});
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  const std::string bytes = read_text(good);
  const std::string pendulum =
      "[body.rod]\nsuperelement = \"bad.se.h5\"\n[joint.pin]\ntype = \"revolute\"\nfrom = \"ground\"\n"
      "to = \"rod.big_end\"\n";

  folder.write("bad.se.h5", bytes.substr(0, bytes.size() * 2 / 3));
  EXPECT_THAT(refusal(pendulum), HasSubstr("bad.se.h5"));

  // One flipped bit, in many places.
  int noticed = 0;
  const int tries = 24;
  for (int k = 1; k <= tries; ++k) {
    std::string flipped = bytes;
    flipped[bytes.size() * k / (tries + 1)] ^= 0x10;
    folder.write("bad.se.h5", flipped);
    const Outcome outcome = run("flexura", {"check", (folder / "bad.se.h5").string()});
    if (outcome.exit_code != 0) {
      ++noticed;
      EXPECT_THAT(outcome.err, AllOf(testing::StartsWith("error: "), HasSubstr("bad.se.h5")));
    }
  }
  // Bytes between datasets (HDF5's free space) carry nothing; nearly all of the file is data.
  EXPECT_GE(noticed, tries - 4);
}

}  // namespace
}  // namespace flexura::test
