// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What processes that were killed leave: taken away by the next command that is to write there, whatever
// becomes of that one; files of others stay.  Programs that a study started end with it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <thread>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"
#include "tests/found/background.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class LeftOver : public ::testing::Test {
 protected:
  std::set<std::string> names(const fs::path& folder) const {
    std::set<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder)) all.insert(entry.path().filename());
    return all;
  }
  /// A run that never ends by itself, killed once it has rows.
  void killed_run(const std::string& output) const {
    Background run("flexura", {"simulate", mechanism_, "-q", "-o", output});
    ASSERT_TRUE(wait_for_rows(output + ".part"));
    run.send(SIGKILL);
    run.wait();
    ASSERT_TRUE(fs::exists(output + ".part"));
  }
  Folder inputs_, folder_;
  std::string mechanism_ = write_long_run(inputs_);
  std::string output_ = folder_ / "r.h5";
};

TEST_F(LeftOver, IsRemovedByTheNextCommandThatIsToWriteThere) {
  folder_.write("r.h5", "old");
  const std::string wrong = inputs_.write("wrong.toml", "[body.b]\nmass = -1\n");
  const std::vector<std::pair<std::vector<std::string>, int>> next = {
      {{"simulate", wrong, "-o", output_}, 2},
      {{"simulate", inputs_ / "none.toml", "-o", output_}, 2},
      {{"simulate", mechanism_, "-q", "-o", output_, "--set", "solver.max_steps=1"}, 1}};
  for (const auto& [words, code] : next) {
    killed_run(output_);
    EXPECT_THAT(names(folder_.path()), ElementsAre(".r.h5.lock", "r.h5", "r.h5.part"));
    EXPECT_EQ(run("flexura", words).exit_code, code);
    EXPECT_THAT(names(folder_.path()), ElementsAre("r.h5"));
    if (code == 2) EXPECT_EQ(read_text(output_), "old");
  }
}

// Twice killed, in the same place, with a private name taken by a file of the user's.
TEST_F(LeftOver, OfSeveralIsRemovedButNotFilesOfOthers) {
  folder_.write("r.h5.part", "half of a download");
  for (int k = 0; k < 2; ++k) {
    Background run("flexura", {"simulate", mechanism_, "-q", "-o", output_});
    // Before its first rows it has a copy beside its file.
    ASSERT_TRUE(wait_for_rows(output_ + "." + std::to_string(run.pid()) + ".part"));
    run.send(SIGKILL);
    run.wait();
    EXPECT_EQ(names(folder_.path()).size(), 3u) << "the lock, the user's and one that was killed";
  }
  EXPECT_EQ(run("flexura", {"simulate", inputs_ / "none.toml", "-o", output_}).exit_code, 2);
  EXPECT_THAT(names(folder_.path()), ElementsAre("r.h5.part"));
  EXPECT_EQ(read_text(output_ + ".part"), "half of a download");
}

// The rows of the killed run are the next command's input.
TEST_F(LeftOver, IsNotRemovedByTheCommandThatReadsIt) {
  killed_run(output_);
  const Outcome outcome = run("flexura", {"outputs", mechanism_, output_ + ".part", "-o", output_, "-q"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(names(folder_.path()), ElementsAre("r.h5", "r.h5.part"));
}

/// Processes that this one has started.
std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> out;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::ifstream stat(entry.path() / "stat");
    std::string text;
    if (!std::getline(stat, text) || text.rfind(')') == std::string::npos) continue;
    std::istringstream rest(text.substr(text.rfind(')') + 1));
    std::string state;
    pid_t of = 0;
    if (rest >> state >> of && of == parent && state != "Z") out.push_back(std::stoi(text));
  }
  return out;
}
bool runs(pid_t pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  return std::getline(stat, text) && text.find(") Z") == std::string::npos;
}

TEST_F(LeftOver, ProgramsThatAStudyStartedEndWithIt) {
  const std::string study = inputs_.write("study.toml", R"toml(mechanism = "long.toml"
cache = "cache"
[choice.a]
set = ["solver.tolerance=1e-5"]
[choice.b]
set = ["solver.tolerance=1e-6"]
[quantity.x]
of = "slide.position"
)toml");
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGKILL}) {
    Background process("flexura", {"study", study, "-j", "2", "-o", folder_ / "s"});
    std::vector<pid_t> started;
    ASSERT_TRUE(wait_for([&] { return (started = children_of(process.pid())).size() == 2; }));
    process.send(signal);
    const Outcome ended = process.wait();
    EXPECT_EQ(ended.exit_code, signal == SIGKILL ? -1 : 1) << ended.err;
    for (const pid_t child : started) EXPECT_TRUE(wait_for([&] { return !runs(child); })) << signal;
    if (signal == SIGKILL) break;
    EXPECT_THAT(ended.err, HasSubstr("the same command goes on from there"));
    for (const std::string& name : names(inputs_ / "cache"))
      EXPECT_FALSE(name.find("by-") != name.npos) << name;
    EXPECT_TRUE(names(folder_.path()).empty());
  }
  // What the killed study left in its cache goes when the next one starts.
  Background next("flexura", {"study", study, "-o", folder_ / "s"});
  ASSERT_TRUE(wait_for([&] { return !children_of(next.pid()).empty(); }));
  for (const std::string& name : names(inputs_ / "cache"))
    if (name.find("by-") != name.npos)
      EXPECT_NE(name.find("-" + std::to_string(next.pid()) + "."), name.npos) << name;
  next.send(SIGTERM);
  EXPECT_EQ(next.wait().exit_code, 1);
}

}  // namespace
}  // namespace flexura::test
