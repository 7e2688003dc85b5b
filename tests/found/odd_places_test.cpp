// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Names that lead to no file: devices and pipes where inputs are wanted, beginnings of names that are none,
// folders in the place of files and the other way round, options without a value.  Each is refused in one
// sentence before anything is computed, and what lay there stays.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "tests/app/command.hpp"
#include "tests/sanitized.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kSafe = FLEXURA_SOURCE_DIR "/tests/found/safe/";
const std::string kMechanism = kSafe + "userlib/m.toml";

void expect_refused(const std::vector<std::string>& words, const std::string& why) {
  const Outcome outcome = run("flexura", words);
  const std::string shown = ::testing::PrintToString(words);
  EXPECT_EQ(outcome.exit_code, 2) << shown << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(why)) << shown;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << shown << outcome.err;
}

class OddPlaces : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new Folder;
    ok({"reduce", kSafe + "poisson/crash_young1e300.toml", "--set", "material.steel.young=210e9", "-o", se(),
        "-q"});
    ok({"simulate", kMechanism, "-o", results(), "-q"});
  }
  static void TearDownTestSuite() {
    delete shared_;
    shared_ = nullptr;
  }
  static void ok(const std::vector<std::string>& words) {
    const Outcome outcome = run("flexura", words);
    ASSERT_EQ(outcome.exit_code, 0) << words[0] << ": " << outcome.err;
  }
  static std::string se() { return *shared_ / "p.se.h5"; }
  static std::string results() { return *shared_ / "r.h5"; }
  bool is_empty() const { return fs::is_empty(mine_.path()); }

  static Folder* shared_;
  Folder mine_;
};
Folder* OddPlaces::shared_ = nullptr;

// A pipe is waited for, /dev/zero is read, for ever.
TEST_F(OddPlaces, DevicesAndPipesAreNoInputs) {
  const Folder f;
  const std::string pipe = f / "pipe";
  ::mkfifo(pipe.c_str(), 0600);
  const std::string out = mine_ / "out";
  for (const std::string& odd : {pipe, std::string("/dev/zero")})
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"simulate", odd, "-o", out},
                                               {"simulate", odd, "-o", out, "--checkpoint", "1 s"},
                                               {"simulate", kMechanism, "-o", out, "--from-state", odd},
                                               {"simulate", kMechanism, "-o", out, "--continue", odd},
                                               {"outputs", kMechanism, odd, "-o", out},
                                               {"reduce", odd, "-o", out},
                                               {"section", odd, "-o", out, "--svg", out + ".svg"},
                                               {"study", odd, "-o", out},
                                               {"report", odd, "-o", out},
                                               {"view", odd, "-o", out},
                                               {"modes", odd, "--html", out},
                                               {"export", odd, "-f", "sid", "-o", out},
                                               {"check", odd}})
      expect_refused(words, odd + ": is a device or a pipe");
  EXPECT_TRUE(is_empty());
}

TEST_F(OddPlaces, AFolderIsNoBeginningOfAName) {
  const std::string here = mine_.path();
  for (const std::string& stem : {here + "/", here + "/.", here + "/.."}) {
    expect_refused({"export", se(), "-f", "matrix-market", "-o", stem}, "is a folder; name files in it");
    expect_refused({"export", results(), "-f", "csv", "-o", stem}, "is a folder; name files in it");
    expect_refused({"export", results(), "-f", "pvd", "-o", stem}, "is a folder; name files in it");
  }
  expect_refused({"export", se(), "-f", "matrix-market", "-o", "/dev/null"}, "is a device or a pipe");
  expect_refused({"export", results(), "-f", "csv", "-o", "/dev/full"}, "is a device or a pipe");
  EXPECT_TRUE(is_empty());
}

// The pictures of a run go into a folder of its own.
TEST_F(OddPlaces, PicturesReplaceNothingButPictures) {
  const std::vector<std::string> words = {"export",   results(), "-f", "pvd",
                                          "--frames", "3",       "-o", mine_ / "out"};
  const fs::path folder = mine_ / "out.run";
  mine_.write("out.run", "kept");
  expect_refused(words, "is no folder");
  EXPECT_EQ(read_text(folder), "kept");
  fs::remove(folder);
  fs::create_directory(folder);
  fs::create_symlink(results(), folder / "00001.vtp");
  expect_refused(words, "a file of another kind");
  EXPECT_TRUE(fs::is_symlink(folder / "00001.vtp"));
  fs::remove(folder / "00001.vtp");
  fs::create_directory(folder / "00001.vtp");
  expect_refused(words, "is a folder");
  EXPECT_FALSE(fs::exists(folder / "00000.vtp"));
  fs::remove(folder / "00001.vtp");
  ok(words);
  EXPECT_TRUE(fs::is_regular_file(folder / "00001.vtp"));
}

TEST_F(OddPlaces, ACacheIsAFolder) {
  const std::string odd = mine_ / "odd", out = mine_ / "out.h5";
  const auto refused = [&] {
    expect_refused({"simulate", kMechanism, "-o", out, "--cache", odd}, "is no folder");
    const auto study = mine_.write("s.toml", "mechanism = \"" + kMechanism + "\"\ncache = \"" + odd +
                                                 "\"\n[choice.a]\n[quantity.x]\nof = \"j.angle\"\n");
    expect_refused({"study", study, "-o", mine_ / "study"}, "no folder of this name can be made");
  };
  mine_.write("odd", "kept");
  refused();
  EXPECT_EQ(read_text(odd), "kept");
  fs::remove(odd);
  fs::create_symlink("odd", odd);  // to itself
  refused();
}

// A variable of the shell that is not set: not the default in its place.
TEST_F(OddPlaces, AnOptionHasAValue) {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"simulate", kMechanism, "-o", ""},
           {"simulate", kMechanism, "-o", mine_ / "r.h5", "--save-state", ""},
           {"view", results(), "--output", ""},
           {"modes", se(), "--html", ""},
           {"modes", se(), "--clamped", ""},
           {"eigen", kMechanism, "--pictures", ""},
           {"eigen", kMechanism, "--count", ""},
           {"eigen", kMechanism, "--pictures", mine_ / "e.h5", "--amplitude", ""},
           {"reduce", kSafe + "beam/h.toml", "-n", ""},
           {"reduce", kSafe + "beam/h.toml", "--beam-modes", ""},
           {"reduce", kSafe + "beam/h.toml", "--compare", ""}})
    expect_refused(words, "the value is empty");
  EXPECT_TRUE(is_empty());
}

TEST_F(OddPlaces, NumbersOfOptionsHaveLimits) {
  const std::string out = mine_ / "x.m";
  for (const char* response : {"1:10:2000000000", "1:inf:3", "nan:2:3", "1e-300:1e300:3", "1:2:99999999999"})
    expect_refused({"linearize", kMechanism, "--frozen", "--input", "j.angle", "--measure", "j.angle",
                    "--response", response, "-o", out},
                   "--response is");
  for (const char* amplitude : {"0", "-1", "inf"})
    expect_refused({"eigen", kMechanism, "--frozen", "--pictures", out, "--amplitude", amplitude},
                   "--amplitude is");
  expect_refused({"eigen", kMechanism, "--frozen", "--pictures", out, "--amplitude", "nan"},
                 "nan is no number");
  expect_refused({"reduce", kSafe + "beam/h.toml", "--modes", "-5", "-o", out}, "-5 is negative");
  EXPECT_TRUE(is_empty());
}

#ifndef FLEXURA_ADDRESS_SANITIZER  // which takes terabytes of address space
// OpenBLAS asks for its work space for ever, in a thread of its own from the program's start on: the end is one
// sentence all the same, and an end.
TEST_F(OddPlaces, LittleAddressSpaceIsAnEndInASentence) {
  const auto script =
      mine_.write("little.sh",
                  "ulimit -v 230000\nexport OPENBLAS_NUM_THREADS=2\nexec timeout -s KILL 20 '" FLEXURA_BIN_DIR
                  "/flexura-reduce' '" +
                      kSafe + "poisson/crash_young1e300.toml' --set material.steel.young=210e9 -o '" +
                      (mine_ / "x.se.h5").string() + "' 2> '" + (mine_ / "err").string() + "'\n");
  const int status = std::system(("bash '" + script.string() + "'").c_str());
  ASSERT_TRUE(WIFEXITED(status));
  const std::string said = read_text(mine_ / "err");
  if (WEXITSTATUS(status) == 127) GTEST_SKIP() << "the loader itself needs more: " << said;
  EXPECT_EQ(WEXITSTATUS(status), 1) << said;
  EXPECT_THAT(said, HasSubstr("out of memory"));
  EXPECT_FALSE(fs::exists(mine_ / "x.se.h5"));
}
#endif

// More threads than a machine has to give: one for each run is enough.
TEST_F(OddPlaces, AStudyTakesAsManyThreadsAsItHasRuns) {
  const auto study = mine_.write(
      "s.toml", "mechanism = \"" + kMechanism +
                    "\"\nrepeats = 1\n[choice.a]\nset = [\"solver.tolerance=1e-5\"]\n[quantity.x]\nof = "
                    "\"j.angle\"\n");
  const Outcome outcome = run("flexura", {"study", study, "-j", "1000000", "-o", mine_ / "study", "-q"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

}  // namespace
}  // namespace flexura::test
