// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// Drives that follow controls, of bodies that deform.
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

}  // namespace
}  // namespace flexura::test
