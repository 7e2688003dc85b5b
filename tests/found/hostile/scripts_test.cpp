// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Files that gmsh would run as scripts (gmsh_script/): each of them leaves the file PWNED where it does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/app/command.hpp"

namespace flexura {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using test::Outcome;
using ::testing::HasSubstr;

/// The samples in a folder of their own, which is the working folder, too: scripts write there.
class Scripts : public ::testing::Test {
 protected:
  Scripts() {
    fs::copy(FLEXURA_SOURCE_DIR "/tests/found/hostile/gmsh_script", folder_.path());
    fs::current_path(folder_.path());
  }
  ~Scripts() override { fs::current_path("/"); }
  bool has_run() const {
    for (const fs::directory_entry& file : fs::recursive_directory_iterator(folder_.path()))
      if (file.path().filename().string().starts_with("PWNED")) return true;
    return false;
  }
  void expect_refused(const std::vector<std::string>& words, const std::string& why) const {
    const Outcome outcome = test::run("flexura", words);
    EXPECT_EQ(outcome.exit_code, 2) << words.back();
    EXPECT_THAT(outcome.err, HasSubstr(why));
    EXPECT_FALSE(has_run()) << words.back();
  }

  Folder folder_;
};

TEST_F(Scripts, OfGmshRunOnlyWhereTheCommandLineSaysSo) {
  expect_refused({"reduce", "beam_geo.toml"},
                 "evil.geo: is a script, which gmsh runs: look through it and give --run-scripts");
  const Outcome outcome = test::run("flexura", {"reduce", "beam_geo.toml", "--run-scripts"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(has_run());  // so these files tell what they are to tell
}

TEST_F(Scripts, AreNoMeshes) {
  expect_refused({"reduce", "beam_msh.toml"}, "does not begin with $MeshFormat");
  expect_refused({"reduce", "solid.toml"}, "does not begin with $MeshFormat");
  expect_refused({"simulate", "mech.toml", "--reduce"}, "does not begin with $MeshFormat");
  expect_refused({"study", "study.toml"}, "does not begin with $MeshFormat");
}

TEST_F(Scripts, AreNoSurfaces) {
  expect_refused({"reduce", "stl.toml"}, "s.Stl: holds no triangle");
  expect_refused({"reduce", "--list-faces", "s.Stl"}, "s.Stl: holds no triangle");
}

TEST_F(Scripts, BesideAMeshAreNotSeen) {
  const Outcome outcome = test::run("flexura", {"reduce", "opt_beside.toml"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(has_run());
}

}  // namespace
}  // namespace flexura
