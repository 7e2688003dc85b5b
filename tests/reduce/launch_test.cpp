// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The reduction program under MPI's launcher.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"

namespace flexura::reduce {
namespace {

TEST(Launch, TwoProcessesGiveTheSameSuperelementAsOne) {
  const test::Folder folder;
  const std::string deck = std::string(FLEXURA_SOURCE_DIR) + "/tests/mesh/data/CHEXA08_.nas";
  const std::string part =
      folder.write("beam.toml", "[geometry]\nfile = \"" + deck + "\"\n[modes]\ncount = 6\n").string();
  const std::string alone = folder / "alone.se.h5", together = folder / "together.se.h5";
  const test::Outcome one = test::run("flexura-reduce", {part, "-o", alone, "-q"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  // Without this program's own environment, in which MPI has started already.
  const auto under_mpirun = [&](std::vector<std::string> arguments) {
    std::vector<std::string> words = {"-i",
                                      "PATH=/usr/bin:/bin",
                                      "HOME=" + folder.path().string(),
                                      "OPENBLAS_NUM_THREADS=1",
                                      "ASAN_OPTIONS=detect_leaks=0",
                                      "/usr/bin/mpirun",
                                      "--allow-run-as-root",
                                      "--oversubscribe",
                                      "-n",
                                      "2",
                                      std::string(FLEXURA_BIN_DIR) + "/flexura-reduce"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return test::run("/usr/bin/env", words);
  };
  const test::Outcome two = under_mpirun({part, "-o", together, "-q"});
  ASSERT_EQ(two.exit_code, 0) << two.err;
  EXPECT_THAT(two.err, ::testing::HasSubstr("2 processes were started"));
  const superelement::Superelement a = superelement::read(alone), b = superelement::read(together);
  // The same program on the same numbers; threads may add in another order.
  EXPECT_LT((a.K_se - b.K_se).norm(), 1e-10 * a.K_se.norm());
  EXPECT_LT((a.M_se - b.M_se).norm(), 1e-10 * a.M_se.norm());
  // A refusal ends all of them.
  const test::Outcome bad = under_mpirun({"missing.toml"});
  EXPECT_NE(bad.exit_code, 0);
  EXPECT_THAT(bad.err, ::testing::HasSubstr("missing.toml"));
}

}  // namespace
}  // namespace flexura::reduce
