// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Folders for temporary files and for outputs that take nothing: a good file stays, and nothing else is left.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "tests/app/command.hpp"

namespace flexura {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using test::Outcome;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string sample(const std::string& name) {
  return std::string(FLEXURA_SOURCE_DIR) + "/tests/found/hostile/" + name;
}

/// TMPDIR for as long as this lives.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const char* folder) { setenv("TMPDIR", folder, 1); }
  ~TemporaryFolder() { unsetenv("TMPDIR"); }
};

// The mesh of first order is 39 % off.
TEST(Faults, NoTemporaryFolderLetsAPoorSuperelementReplaceAGoodOne) {
  const Folder folder;
  const std::string output = folder / "o.se.h5";
  ASSERT_EQ(
      test::run("flexura", {"reduce", sample("keep_better/blockC3D10.toml"), "-q", "-o", output}).exit_code,
      0);
  const std::string good = test::read_text(output);
  for (const char* place : {"/proc", "/nonexistent", "/dev/full", ""}) {  // in which nobody makes a file
    const TemporaryFolder elsewhere(place);
    const Outcome poor =
        test::run("flexura", {"reduce", sample("keep_better/blockC3D4.toml"), "-q", "-o", output});
    EXPECT_EQ(poor.exit_code, 1) << place;
    EXPECT_THAT(poor.err, HasSubstr("o.se.h5, which resolves it, is kept")) << place;
    EXPECT_EQ(test::read_text(output), good) << place;
  }
}

// Its frequencies are known to 20 %, its static compliance is not.
TEST(Faults, TheSameReductionTwiceDoesTheSame) {
  const Folder folder;
  const std::string output = folder / "o.se.h5";
  for (int time = 1; time <= 2; ++time) {
    const Outcome outcome =
        test::run("flexura", {"reduce", sample("keep_better/bar.toml"), "-q", "-o", output});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("does not resolve the part"));
  }
}

TEST(Faults, ASuperelementThatCannotBeReadIsKeptToo) {
  const Folder folder;
  const fs::path output = folder.write("o.se.h5", "\x89HDF\r\n\x1a\n and no more");
  const Outcome poor =
      test::run("flexura", {"reduce", sample("keep_better/blockC3D4.toml"), "-q", "-o", output.string()});
  EXPECT_EQ(poor.exit_code, 1);
  EXPECT_THAT(poor.err, AllOf(HasSubstr("of which nobody knows whether it does"), HasSubstr("is kept")));
  EXPECT_EQ(fs::file_size(output), 20u);
}

TEST(Faults, OfTheTemporaryFolderNameIt) {
  const Folder folder;
  const TemporaryFolder elsewhere("/nonexistent");
  const Outcome outcome = test::run("flexura", {"reduce", sample("keep_better/blockC3D10.toml"),
                                                "--factor-in-file", "-q", "-o", folder / "o.se.h5"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err,
              HasSubstr("cannot be made in /nonexistent (No such file or directory): set TMPDIR"));
}

TEST(Faults, OfAnOutputFolderAreToldByItsName) {
  const Outcome outcome = test::run("flexura", {"examples", "steam_engine", "-o", "/proc/steam_engine"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("/proc/steam_engine: cannot be written in /proc"));
}

TEST(Faults, LeaveNoFolders) {
  const Folder folder;
  // A robot whose picture cannot be written: its place is a folder.
  fs::create_directories(folder / "robot/mechanism.toml");
  const Outcome outcome =
      test::run("flexura", {"import", std::string(FLEXURA_SOURCE_DIR) + "/tests/import/data/arm.urdf",
                            "--force", "-o", folder / "robot"});
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_FALSE(fs::exists(folder / "robot/parts"));
}

// A file says where it is read, the command line where it is written.
TEST(Faults, OfAStudyItsCacheLiesBesideItOrWhereTheCommandLineSays) {
  const Folder folder;
  fs::create_directory(folder / "own");
  fs::copy(sample("study/rr.toml"), folder / "own/rr.toml");
  const auto write = [&](const std::string& cache) {
    return folder
        .write("own/s.toml",
               "mechanism = \"rr.toml\"\nrepeats = 1\n" + cache +
                   "[axis.a]\nkey = \"parameters.x0\"\nvalues = [\"1\", \"2\"]\n[quantity.a]\nof = "
                   "\"hinge.angle\"\n")
        .string();
  };
  const std::string stem = folder / "out";
  for (const char* cache : {"cache = \"../evil/cache\"\n", "cache = \"/tmp/flexura-evil\"\n"}) {
    const Outcome outcome = test::run("flexura", {"study", write(cache), "-q", "-o", stem});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("lies neither in the study file's folder nor in the working folder"));
  }
  EXPECT_FALSE(fs::exists(folder / "evil"));
  fs::create_directory(folder / "elsewhere");
  fs::create_directory_symlink("../elsewhere", folder / "own/study.cache");
  EXPECT_EQ(test::run("flexura", {"study", write(""), "-q", "-o", stem}).exit_code, 2);
  EXPECT_TRUE(fs::is_empty(folder / "elsewhere"));
  const std::string told = "cache=" + (folder / "elsewhere").string();
  EXPECT_EQ(test::run("flexura", {"study", write(""), "-q", "-o", stem, "--set", told}).exit_code, 0);
  EXPECT_FALSE(fs::is_empty(folder / "elsewhere"));
}

}  // namespace
}  // namespace flexura
