// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// Mechanisms that the random ones of tests/mbs/random found wrong.
namespace flexura {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using test::Outcome;

const std::string kFolder = std::string(FLEXURA_SOURCE_DIR) + "/tests/found/random/";

results::Run run_of(const test::Folder& folder, const std::string& name, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"simulate", kFolder + name + ".toml", "-o", folder / "rows.h5", "--no-estimate"};
  words.insert(words.end(), more.begin(), more.end());
  const Outcome outcome = test::run("flexura", words);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return results::read(folder / "rows.h5").runs.at(0);
}

double column(const results::Run& run, const std::string& quantity, Eigen::Index row) {
  for (std::size_t i = 0; i < run.quantities.size(); ++i)
    if (run.quantities[i].name == quantity) return run.values(row, static_cast<Eigen::Index>(i));
  throw std::logic_error("no quantity " + quantity);
}

// Axes that differ in the ninth digit hold nothing: the drive was left out in their favour and called a contradiction.
TEST(RandomSamples, LoopsWithNineDigitsFollowTheirDrives) {
  const test::Folder folder;
  for (const char* name : {"door_nine_digits_driven", "parallelogram_nine_digits_driven"}) {
    const results::Run run = run_of(folder, name);
    EXPECT_TRUE(run.complete) << run.stopped_because;
    EXPECT_GT(run.time.size(), 20) << name;
  }
}

// Two doors geared to each other: the multiplier of such an axis was -5.8e8, the accelerations wrong by their size
// and the run ended at its start.
TEST(RandomSamples, DoorsWithNineDigitsHaveForcesOfTheSizeOfTheirLoads) {
  const test::Folder folder;
  const results::Run run = run_of(folder, "door_geared_nine_digits");
  EXPECT_TRUE(run.complete) << run.stopped_because;
  // Some kilograms, accelerated by some metres per second squared.
  EXPECT_LT(std::abs(column(run, "j2.force", 0)), 1e4);
  EXPECT_LT(std::abs(column(run, "j2.torque", 0)), 1e4);
}

// A door on two hinges that are open by less elsewhere: closing them to the last digit turned the door by 0.5 rad.
TEST(RandomSamples, DoorsStartWhereTheyStand) {
  const test::Folder folder;
  const results::Run run = run_of(folder, "door_in_millimetres");
  // Of the markers: atan2(R_10, R_00) of R_FM.
  EXPECT_NEAR(column(run, "j0.angle", 0), -1.4179146, 1e-7);
}

// The precession of a body that does not turn was a quotient of zeros: "the mass matrix is not positive definite
// (diagonal entry nan)". It falls.
TEST(RandomSamples, ABodyAtRestHasNoPrecession) {
  const Outcome outcome = test::run("flexura", {"eigen", kFolder + "free_body_at_rest.toml"});
  EXPECT_THAT(outcome.err, Not(HasSubstr("nan")));
  EXPECT_THAT(outcome.err, Not(HasSubstr("mass matrix")));
}

// Work of drives was taken from multipliers that answer to no error test: open by 0.1 to 2 % where the motion is exact.
TEST(RandomSamples, TheWorkOfADriveIsThatOfItsTorque) {
  const test::Folder folder;
  const results::Run run = run_of(folder, "wheel_driven_evenly");
  // From 0 to 6 rad at constant speed: the weight's work, m g e sin(6).
  const double work = 2.0 * 9.81 * 0.1 * std::sin(6.0);
  const Eigen::Index last = run.time.size() - 1;
  EXPECT_NEAR(column(run, "energy.input", last), work, 1e-6 * std::abs(work) + 1e-6);
  EXPECT_LT(std::abs(column(run, "energy.balance", last)), 2e-6);
}

}  // namespace
}  // namespace flexura
