// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// Drives that follow controls, of bodies that deform; drives that lead where rest is asked for.
namespace flexura::test {
namespace {

const std::filesystem::path kFound = std::filesystem::path(FLEXURA_SOURCE_DIR) / "tests/found";

// "rows that follow states are asked for without them" where a body deformed, with every method: the look at what its bending would
// shorten took the rows without their states. The same hinge driven by the acceleration that follows, with its speed at the start, moves
// alike; the tolerance of both runs is 1e-8, and 1e-5 what this leaves of the drive's torque, which rings.
TEST(Drives, OfBodiesThatDeformFollowControls) {
  const Folder folder;
  ASSERT_EQ(
      run("flexura", {"reduce", kFound / "estimates/soft_arm.toml", "-q", "-o", folder / "soft_arm.se.h5"})
          .exit_code,
      0);
  const std::string text = read_text(kFound / "drives/arm_by_drive.toml");
  const auto values = [&](const std::string& name, const std::string& scene) {
    const Outcome out = run("flexura", {"simulate", folder.write(name + ".toml", scene), "-q",
                                        "--no-estimate", "-o", folder / (name + ".h5")});
    EXPECT_EQ(out.exit_code, 0) << out.err;
    return results::read(folder / (name + ".h5")).runs.at(0).values;
  };
  const Eigen::MatrixXd by_speed = values("speed", text),
                        by_acceleration =
                            values("acceleration", replaced(text, "drive_speed = \"3*(0.5 - seen)\"",
                                                            "speed = \"1.5 rad/s\"\n"
                                                            "drive_acceleration = \"-3*(tip - seen)/0.02\""));
  // hinge.speed is what the drive says.
  EXPECT_LT((by_speed.col(1) - 3.0 * (0.5 - by_speed.col(2).array()).matrix()).cwiseAbs().maxCoeff(), 1e-6);
  for (const int column : {0, 1, 2, 3, 4})
    EXPECT_LT((by_speed.col(column) - by_acceleration.col(column)).norm(), 1e-5 * by_speed.col(column).norm())
        << column;
}

// "no equilibrium" and "equilibrium in 1 step, largest force left 0 N" of one state: a drive that leads at any speed has none, with
// `statics` as with `eigen --equilibrium`; the same mechanism has one where the drive stands.
TEST(Drives, ThatLeadHaveNoEquilibrium) {
  using ::testing::HasSubstr;
  using ::testing::Not;
  const Folder folder;
  std::mt19937 random(20261128);
  std::uniform_real_distribution<double> exponent(-6.0, 2.0);
  for (int i = 0; i < 40; ++i) {
    const bool turns = random() % 2 == 0, stands = i % 5 == 0;
    const double speed = stands ? 0.0 : (random() % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, exponent(random));
    const std::string file = folder.write(
        "led.toml",
        fmt::format("[body.a]\nmass = 2\ninertia = [1, 1, 1]\n[joint.j]\ntype = \"{}\"\nfrom = "
                    "\"ground\"\nto = \"a\"\ndrive_speed = \"{}\"\n[body.b]\nmass = 1\ninertia = [1, "
                    "1, 1]\n[joint.k]\ntype = \"prismatic\"\nfrom = \"a\"\nto = \"b\"\n[force.s]\ntype = "
                    "\"joint_spring_damper\"\njoint = \"k\"\nstiffness = 300\ndamping = 2\n",
                    turns ? "revolute" : "prismatic", speed));
    SCOPED_TRACE(read_text(file));
    const Outcome text = run("flexura", {"statics", file}),
                  json = run("flexura", {"statics", file, "--json"});
    ASSERT_EQ(text.exit_code, 0) << text.err;
    const auto told = nlohmann::json::parse(json.out)["runs"][0];
    if (stands) {
      EXPECT_THAT(text.out, HasSubstr("equilibrium in "));
      EXPECT_THAT(text.err, Not(HasSubstr("no equilibrium")));
      continue;
    }
    EXPECT_THAT(text.err, HasSubstr("no equilibrium: \"j."));
    EXPECT_THAT(text.out, Not(HasSubstr("equilibrium in ")));
    EXPECT_THAT(text.out, Not(HasSubstr("the equilibrium is")));
    EXPECT_EQ(told["stability"], "unknown");
  }
}

}  // namespace
}  // namespace flexura::test
