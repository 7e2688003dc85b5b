// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The four-bar press of user/: its loop closes by turning joints from a guess 9 degrees off and from a stretched one; a mount
// 1 mm aside is named.  Its three parts are meshed coarsely: what is asked here does not depend on the mesh.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class FourBar : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    for (const auto& entry : fs::directory_iterator(fs::path(FLEXURA_SOURCE_DIR) / "tests/found/user"))
      fs::copy(entry.path(), folder_->path());
    for (const std::string part : {"crank_arm", "rod", "bracket"}) {
      const Outcome made =
          run("flexura-reduce", {*folder_ / (part + ".toml"), "-o", *folder_ / (part + ".se.h5"), "-q",
                                 "--mesh-size", "12 mm", "--set", "modes.count=2"});
      ASSERT_EQ(made.exit_code, 0) << made.err;
    }
  }
  static void TearDownTestSuite() { delete folder_; }

  static Outcome start(const std::string& name) {
    return run("flexura", {"simulate", *folder_ / (name + ".toml"), "-o", *folder_ / (name + ".h5"),
                           "--no-estimate", "--end-time", "1e-6", "--set", "solver.output_step=1e-6"});
  }
  // Crank pin and pivot are 180 mm apart, the pivot `down` mm lower; rod and rocker are 250 mm long.
  static void expect_closed(const std::string& name, double down) {
    const double half = std::acos(0.5 * std::hypot(180.0, down) / 250.0), tilt = std::atan(down / 180.0);
    const auto file = results::read(*folder_ / (name + ".h5"));
    ASSERT_EQ(file.runs.size(), 2u);
    for (const results::Run& one : file.runs) {
      std::map<std::string, double> at;
      for (std::size_t k = 0; k < one.quantities.size(); ++k)
        at[one.quantities[k].name] = one.values(0, static_cast<Eigen::Index>(k));
      EXPECT_NEAR(at.at("a.angle"), tilt - half, 1e-6) << one.name;
      EXPECT_NEAR(at.at("pivot.angle"), tilt + half, 1e-6) << one.name;
      if (at.contains("energy.strain")) EXPECT_LT(at.at("energy.strain"), 1e-9) << one.name;  // was 3.5 kJ
    }
  }
  static inline Folder* folder_ = nullptr;
};

TEST_F(FourBar, ClosesByTurningFromAGuessNineDegreesOff) {
  const Outcome outcome = start("fourbar_guess60");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("were moved"));
  expect_closed("fourbar_guess60", 0.0);
}

TEST_F(FourBar, ClosesFromAStretchedStart) {
  const Outcome outcome = start("fourbar_collinear");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("lead to no closed loops of themselves"));
  expect_closed("fourbar_collinear", 5.0);
}

TEST_F(FourBar, AMountOneMillimetreAsideIsNamedAndShown) {
  const Outcome outcome = start("fourbar_unassembled");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("\"b\" (from \"rod.big\" to \"rocker.small\") by 1 mm"),
                                 HasSubstr("fourbar_unassembled.open.html")));
  EXPECT_FALSE(fs::exists(*folder_ / "fourbar_unassembled.h5"));
  EXPECT_TRUE(fs::exists("fourbar_unassembled.open.html") ||
              fs::exists(*folder_ / "fourbar_unassembled.open.html"));
  fs::remove("fourbar_unassembled.open.html");
}

}  // namespace
}  // namespace flexura::test
