// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What may never be lost: inputs, files of other processes, old results.  Every command that writes, against
// every way of naming an output wrongly; ends by signals, full disks and closed pipes.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <thread>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"
#include "tests/found/background.hpp"
#include "tests/found/writers.hpp"
#include "tests/mbs/app/run_program.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    all[entry.path().string()] = entry.is_symlink()        ? "link"
                                 : entry.is_regular_file() ? read_text(entry.path())
                                                           : "folder";
  return all;
}

class EveryWriter : public Outputs, public ::testing::WithParamInterface<Writer> {
 protected:
  void SetUp() override {
    for (const auto& entry : fs::directory_iterator(folder_->path()))
      fs::copy(entry.path(), mine_ / entry.path().filename().string());
  }
  Outcome write_to(const std::string& out) const { return run("flexura", words_for(out)); }
  std::vector<std::string> words_for(const std::string& out) const {
    std::vector<std::string> words;
    for (const std::string& word : GetParam().words) {
      const std::string placed = word.starts_with("OUT") ? replaced(word, "OUT", out) : word;
      std::error_code none;
      words.push_back(fs::exists(mine_ / placed, none) || placed.starts_with("other")
                          ? (mine_ / placed).string()
                          : placed);
    }
    return words;
  }
  std::string out() const { return mine_ / GetParam().out; }
  /// The file that the command writes for this name.
  std::string written(const std::string& out) const {
    fs::path stem = out;
    if (GetParam().ending == ".run.csv") stem.replace_extension();
    return stem.string() + GetParam().ending;
  }
  void expect_refused(const std::string& out, const std::string& why) const {
    const auto before = contents(mine_.path());
    const Outcome outcome = write_to(out);
    EXPECT_EQ(outcome.exit_code, 2) << why << '\n' << outcome.err;
    EXPECT_EQ(outcome.out, "") << why;
    EXPECT_THAT(outcome.err, HasSubstr(why));
    EXPECT_EQ(contents(mine_.path()), before) << why;
  }
  Folder mine_;
};

TEST_P(EveryWriter, NeverReplacesWhatItReads) {
  for (const std::string& input : GetParam().inputs) {
    fs::create_symlink(mine_ / input, written(out()));
    expect_refused(out(), "would be overwritten");
    fs::remove(written(out()));
  }
  fs::create_hard_link(mine_ / GetParam().inputs.back(), written(out()));
  expect_refused(out(), "would be overwritten");
}

TEST_P(EveryWriter, RefusesPlacesWhereNoFileCanBe) {
  fs::create_directory(written(out()));
  expect_refused(out(), "is a folder");
  fs::remove(written(out()));
  expect_refused(mine_ / "nowhere" / GetParam().out, "does not exist; make it first");
  expect_refused(mine_ / "lift.txt" / GetParam().out, "is a file, not a folder");
  ::mkfifo(written(out()).c_str(), 0600);
  expect_refused(out(), "is a device or a pipe");
  fs::remove(written(out()));
  fs::create_symlink(written(out()), written(out()));
  expect_refused(out(), "is a symbolic link that leads back to itself");
  fs::remove(written(out()));
  mine_.write(fs::path(written(out())).filename(), "kept");
  fs::permissions(written(out()), fs::perms::owner_read);
  expect_refused(out(), "is read-only");
}

TEST_P(EveryWriter, LeavesAFileThatAnotherProcessWrites) {
  const fs::path file = written(out());
  const fs::path lock = file.parent_path() / ("." + file.filename().string() + ".lock");
  const int held = ::open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  ASSERT_EQ(::flock(held, LOCK_EX), 0);
  ASSERT_EQ(::write(held, "4711 \n", 6), 6);
  const auto before = contents(mine_.path());
  const Outcome outcome = write_to(out());
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("is being written by process 4711"));
  EXPECT_EQ(contents(mine_.path()), before);
  ::close(held);
  if (!GetParam().is_quick) return;
  // A lock that nobody holds is that of a process that was killed.
  const Outcome after = write_to(out());
  EXPECT_EQ(after.exit_code, 0) << after.err;
  EXPECT_TRUE(fs::is_regular_file(file));
  for (const auto& [name, content] : contents(mine_.path())) {
    EXPECT_FALSE(name.ends_with(".part")) << name;
    EXPECT_FALSE(name.ends_with(".lock")) << name;
  }
}

// Wherever the signal strikes: the old file, the whole new one, or the rows until then with a sentence.
TEST_P(EveryWriter, EndsBySignalsWithoutAHalfFile) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  ASSERT_EQ(write_to(out()).exit_code, 0);
  const auto whole = Clock::now() - begin;
  const fs::path file = written(out());
  ASSERT_TRUE(fs::is_regular_file(file));
  const auto files = contents(mine_.path());
  const auto first_size = static_cast<double>(fs::file_size(file));
  int moment = 0;
  for (const int signal : {SIGTERM, SIGHUP, SIGINT}) {
    mine_.write(file.filename(), "kept");
    Background program("flexura", words_for(out()));
    std::this_thread::sleep_for(whole * ++moment / 4);
    program.send(signal);
    const Outcome outcome = program.wait();
    const std::string now = read_text(file);
    const bool is_partial = outcome.exit_code == 1 && outcome.err.find("until then") != std::string::npos;
    if (outcome.exit_code == 0 || is_partial)
      EXPECT_NE(now, "kept") << outcome.err;
    else if (now != "kept") {
      // The signal came between the renaming and the end: the new file is whole (as long as the first, but for
      // the digits of its times).
      EXPECT_EQ(outcome.exit_code, -1) << outcome.err;
      EXPECT_NEAR(static_cast<double>(now.size()), first_size, 64) << outcome.err;
    }
    EXPECT_THAT(outcome.err, Not(HasSubstr("internal")));
    for (const auto& [name, content] : contents(mine_.path()))
      EXPECT_TRUE(files.contains(name)) << name << " is left behind";
  }
}

INSTANTIATE_TEST_SUITE_P(Commands, EveryWriter, ::testing::ValuesIn(writers()),
                         [](const auto& writer) { return writer.param.name; });

TEST_F(Outputs, TwoOutputsOfOneCommandAreTwoFiles) {
  const Folder f;
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"simulate", *folder_ / "m.toml", "-o", f / "a", "--save-state", f / "a"},
           {"simulate", *folder_ / "m.toml", "-o", f / "a", "--save-state", f.path() / "." / "a"},
           {"reduce", *folder_ / "boom.toml", "-o", f / "a", "--report", f / "a"}}) {
    const Outcome outcome = run("flexura", words);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("are one file"));
    EXPECT_TRUE(fs::is_empty(f.path()));
  }
}

// A link to a file elsewhere stays a link: what it leads to is replaced.
TEST_F(Outputs, ALinkIsFollowed) {
  const Folder f;
  fs::create_directory(f / "far");
  fs::create_symlink(f.path() / "far" / "real.html", f / "page.html");
  ok({"report", *folder_ / "beam.se.h5", "-o", f / "page.html", "-q"});
  EXPECT_TRUE(fs::is_symlink(f / "page.html"));
  EXPECT_TRUE(fs::is_regular_file(f.path() / "far" / "real.html"));
}

// The values of a mechanism overflow in its first rows: nothing is left, and the old results are.
TEST_F(Outputs, ABadMechanismLeavesNothingBesideTheOldResults) {
  const Folder f;
  f.write("r.h5", "old");
  const Outcome outcome = run(
      "flexura", {"simulate", FLEXURA_SOURCE_DIR "/tests/found/safe/misc/part_left.toml", "-o", f / "r.h5"});
  EXPECT_NE(outcome.exit_code, 0);
  for (const auto& entry : fs::directory_iterator(f.path())) EXPECT_EQ(entry.path().filename(), "r.h5");
}

// SIGTERM and SIGHUP as Ctrl-C: the rows and the states are kept, and it is said; a second process that wants
// the same output meanwhile is told who has it, and takes nothing from it.
TEST_F(Outputs, SignalsEndARunCleanlyAndASecondOneIsRefused) {
  for (const int signal : {SIGTERM, SIGHUP, SIGINT}) {
    const Folder f;
    const std::string mechanism = write_long_run(f);
    Background first("flexura", {"simulate", mechanism, "-o", f / "r.h5", "--save-state", f / "s.json"});
    ASSERT_TRUE(wait_for_rows(f / "r.h5.part"));
    const Outcome second = run("flexura", {"simulate", mechanism, "-o", f / "r.h5"});
    EXPECT_EQ(second.exit_code, 2);
    EXPECT_THAT(second.err, HasSubstr("is being written by process " + std::to_string(first.pid())));
    first.send(signal);
    const Outcome ended = first.wait();
    EXPECT_EQ(ended.exit_code, 1) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("interrupted at t = "));
    EXPECT_THAT(ended.err, HasSubstr("what was computed until then is in"));
    EXPECT_GT(results::read(f / "r.h5").runs.at(0).time.size(), 0);
    EXPECT_EQ(run("flexura", {"simulate", mechanism, "-o", f / "x.h5", "--from-state", f / "s.json", "--set",
                              "solver.max_steps=1"})
                  .exit_code,
              1);
    EXPECT_FALSE(fs::exists(f / "r.h5.part"));
    EXPECT_FALSE(fs::exists(f / ".r.h5.lock"));
  }
}

// A reduction has nothing worth keeping before its end: it takes its files away and dies by the signal.
TEST_F(Outputs, SignalsEndAReductionWithoutATrace) {
  for (const int signal : {SIGTERM, SIGHUP, SIGINT}) {
    const Folder f;
    Background reduce("flexura",
                      {"reduce", FLEXURA_SOURCE_DIR "/cases/steam_engine/conrod.toml", "-o", f / "c.se.h5"});
    ASSERT_TRUE(wait_for([&] { return fs::exists(f / ".c.se.h5.lock"); }));
    reduce.send(signal);
    const Outcome outcome = reduce.wait();
    EXPECT_EQ(outcome.exit_code, -1);
    EXPECT_THAT(outcome.err, HasSubstr("error: interrupted by SIG"));
    EXPECT_TRUE(fs::is_empty(f.path()));
  }
}

testing::Outcome shell(const std::string& text) {
  const Folder f;
  return testing::run_program("bash " + f.write("script.sh", text).string());
}
const std::string kFlexura = FLEXURA_BIN_DIR "/flexura ";

TEST_F(Outputs, StandardOutputThatCannotBeWrittenIsAFailure) {
  const std::string beam = *folder_ / "beam.se.h5", part = *folder_ / "boom.toml";
  for (const std::string& command :
       {"modes " + beam, "modes --json " + beam, std::string("man"), std::string("--help"),
        std::string("simulate --schema"), "reduce --statics " + part, std::string("reduce --schema"),
        "check " + beam}) {
    for (const std::string& where :
         {std::string("> /dev/full"), std::string(">&-"), std::string("| true; exit ${PIPESTATUS[0]}")}) {
      if (where.starts_with("|") && command != "modes " + beam) continue;  // a race, made sure of below
      const std::string paused = where.starts_with("|")
                                     ? "(sleep 0.3; exec " + kFlexura + command + ") " + where
                                     : kFlexura + command + " " + where;
      const auto outcome = shell(paused);
      EXPECT_EQ(outcome.code, 1) << command << where << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr("standard output cannot be written")) << command << where;
    }
  }
}

// Nothing of ours is opened in the place of a closed stream: messages would go into it.
TEST_F(Outputs, ClosedStreamsDoNoHarmToOutputs) {
  const Folder f;
  const auto outcome = shell(kFlexura + "simulate " + (*folder_ / "m.toml").string() + " -o " +
                             (f / "r.h5").string() + " -v <&- 2>&-");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(results::read(f / "r.h5").runs.at(0).time.size(), 11);
}

// Files may have no more than some blocks of 1024 bytes here, as where a quota ends.
TEST_F(Outputs, AQuotaLeavesTheOldFileAndNothingElse) {
  for (const std::string& command :
       {"simulate " + (*folder_ / "m.toml").string() + " --set solver.output_step='\"1 us\"' -q -o ",
        "reduce " + (*folder_ / "boom.toml").string() + " -q -o ",
        "view " + (*folder_ / "r.h5").string() + " -q -o ",
        "export " + (*folder_ / "beam.se.h5").string() + " -f gmsh -q -o ",
        "eigen " + (*folder_ / "m.toml").string() + " -q --frozen --pictures "}) {
    const Folder f;
    f.write("old", "old");
    const auto outcome = shell("ulimit -f 3\n" + kFlexura + command + (f / "old").string());
    EXPECT_EQ(outcome.code, 1) << command << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("error: ")) << outcome.err;
    EXPECT_EQ(read_text(f / "old"), "old");
    EXPECT_EQ(contents(f.path()).size(), 1u) << command;
  }
}

/// Runs the text where `options` are mounted on DIR, in a mount table of its own.
testing::Outcome mounted(const Folder& f, const std::string& mount, const std::string& text) {
  return testing::run_program(
      "unshare -m bash " +
      f.write("mounted.sh", "dir=" + (f / "dir").string() + "\n" + mount + " || exit 77\n" + text).string());
}
bool may_mount() {
  const Folder f;
  fs::create_directory(f / "dir");
  return mounted(f, "mount -t tmpfs -o size=64k none $dir", "exit 0").code == 0;
}

TEST_F(Outputs, AFullDiskLeavesTheOldFileAndNothingElse) {
  if (!may_mount()) GTEST_SKIP() << "mounting a small tmpfs is not permitted here";
  const std::string m = (*folder_ / "m.toml").string();
  for (const std::string& command : {"simulate " + m + " --set solver.output_step='\"2 us\"' -q -o ",
                                     "reduce " + (*folder_ / "boom.toml").string() + " -q -o ",
                                     "view " + (*folder_ / "r.h5").string() + " -q -o "}) {
    const Folder f;
    fs::create_directory(f / "dir");
    const auto outcome = mounted(
        f, "mount -t tmpfs -o size=48k none $dir",
        "echo old > $dir/old\n" + kFlexura + command + "$dir/old\necho code $?\ncat $dir/old\nls -A $dir");
    EXPECT_EQ(outcome.out, "code 1\nold\nold\n") << command << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("error: ")) << outcome.err;
  }
}

TEST_F(Outputs, TooSmallADiskIsSaidAtTheStart) {
  if (!may_mount()) GTEST_SKIP() << "mounting a small tmpfs is not permitted here";
  const Folder f;
  fs::create_directory(f / "dir");
  const std::string mechanism = write_long_run(f);
  const auto outcome =
      mounted(f, "mount -t tmpfs -o size=1m none $dir",
              kFlexura + "simulate " + mechanism + " -o $dir/r.h5; echo code $?; ls -A $dir");
  EXPECT_EQ(outcome.out, "code 1\n");
  EXPECT_THAT(outcome.err, HasSubstr("are expected, and"));
}

// root may write anywhere; a file system that is mounted for reading only stops root, too.
TEST_F(Outputs, AReadOnlyPlaceIsSaidAtTheStart) {
  if (!may_mount()) GTEST_SKIP() << "mounting is not permitted here";
  for (const Writer& writer : writers()) {
    if (writer.name != "reduce" && writer.name != "simulate" && writer.name != "view") continue;
    const Folder f;
    fs::create_directory(f / "dir");
    std::string command;
    for (const std::string& word : writer.words)
      command += " " + (word == "OUT"                 ? "$dir/out"
                        : fs::exists(*folder_ / word) ? (*folder_ / word).string()
                                                      : word);
    const auto outcome = mounted(f, "mount -t tmpfs -o ro,size=64k none $dir", kFlexura + command);
    EXPECT_EQ(outcome.code, 2) << writer.name;
    EXPECT_THAT(outcome.err, HasSubstr("is on a read-only file system"));
  }
}

}  // namespace
}  // namespace flexura::test
