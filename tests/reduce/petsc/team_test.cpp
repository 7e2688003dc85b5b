// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What goes wrong on one of several processes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/command.hpp"

namespace flexura::linalg {
namespace {

using ::testing::HasSubstr;

test::Outcome three(const std::string& what) {
  return test::run("/usr/bin/env", {"-i", "PATH=/usr/bin:/bin", "HOME=/tmp", "OPENBLAS_NUM_THREADS=1",
                                    "ASAN_OPTIONS=detect_leaks=0", "/usr/bin/mpirun", "--allow-run-as-root",
                                    "--oversubscribe", "-n", "3",
                                    std::string(FLEXURA_BIN_DIR) + "/../tests/bin/team_processes", what});
}

TEST(Team, WhatOneRankFindsIsThrownOnAllAndTheTeamGoesOn) {
  EXPECT_EQ(three("nothing").out, "well\nwell\n");
  EXPECT_EQ(three("input").out, "bad input: cell 7 is flat\nbad input: cell 7 is flat\n");
  EXPECT_EQ(three("failure").out, "failed: the disk is gone\nfailed: the disk is gone\n");
  EXPECT_EQ(three("everywhere").out, "failed: no convergence, number 1\nfailed: no convergence, number 1\n");
}

TEST(Team, AProcessWithoutMemoryOrKilledEndsAllWithAMessage) {
  const test::Outcome memory = three("memory");
  EXPECT_NE(memory.exit_code, 0);
  EXPECT_THAT(memory.err, HasSubstr("process 2 of 3: memory has run out; more machines bring more of it"));
  const test::Outcome killed = three("killed");
  EXPECT_NE(killed.exit_code, 0);
  EXPECT_THAT(killed.err, HasSubstr("signal 9"));  // OpenMPI's words
}

}  // namespace
}  // namespace flexura::linalg
