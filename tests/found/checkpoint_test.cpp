// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A run that is killed and gone on with gives the results of one that never was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "mbs/base/documents/content_hash.hpp"
#include "mbs/results/results.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/found/background.hpp"
#include "tests/mbs/superelement/box_beam.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::ordered_json;

// A flexible pendulum, whose estimate follows modes that it leaves out, and a ball on a floor with its
// switches; two runs, so that one has ended when the other is cut.
const std::string kMechanism = R"toml(
[body.rod]
superelement = "beam.se.h5"
modes = 2
[ground.marker.pivot]
position = [0, 0, 2]
axis = [0, 1, 0]
[joint.hinge]
type = "revolute"
from = "ground.pivot"
to = "rod.left"
[body.ball]
mass = 1
inertia = [1, 1, 1]
[joint.guide]
type = "prismatic"
from = "ground"
to = "ball"
position = 1
[force.floor]
type = "contact"
from = "ground"
to = "ball"
radius = 0.1
stiffness = 1e5
damping = 20
[solver]
end_time = "6 s"
output_step = "5 ms"
store_states = true
[run.first]
set = []
[run.second]
set = ["solver.method=ida"]
)toml";

/// All numbers of a results file but the wall times, as one text; doubles by their bits.
std::string contents(const fs::path& file) {
  const results::Results all = results::read(file);
  std::string out;
  const auto add = [&](const auto& matrix) {
    out.append(reinterpret_cast<const char*>(matrix.data()),
               sizeof(double) * static_cast<std::size_t>(matrix.size()));
  };
  for (const results::Run& run : all.runs) {
    out += run.name + (run.complete ? " complete " : " ") + run.stopped_because;
    nlohmann::json summary = nlohmann::json::parse(run.summary_json);
    const std::function<void(nlohmann::json&)> without_wall = [&](nlohmann::json& value) {
      if (value.is_object())
        for (const char* const key : {"wall_time", "real_time_factor", "wall"}) value.erase(key);
      if (value.is_structured())
        for (auto& part : value) without_wall(part);
    };
    without_wall(summary);
    out += summary.dump();
    add(run.time);
    add(run.values);
    add(run.states);
    for (const results::BodyHistory& body : run.bodies) {
      add(body.pose);
      add(body.modal);
    }
  }
  return out;
}

class Checkpoint : public ::testing::Test {
 protected:
  void SetUp() override {
    superelement::write(folder_ / "beam.se.h5", superelement::testing::make_box_beam());
    mechanism_ = folder_.write("m.toml", text());
  }
  static std::string text() { return kMechanism; }
  std::vector<std::string> words(const std::vector<std::string>& more) const {
    std::vector<std::string> all{"simulate", mechanism_};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// Kills the process once it has written a checkpoint that was not there before; false where it had ended.
  bool killed(Background& process, int pause_ms) const {
    const fs::path newest = out_ + ".checkpoint";
    std::error_code none;
    const auto before = fs::last_write_time(newest, none);
    const bool had_one = !none;
    EXPECT_TRUE(wait_for([&] {
      std::error_code missing;
      const auto now = fs::last_write_time(newest, missing);
      return process.has_ended() || (!missing && (!had_one || now != before));
    }));
    std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
    const bool had_ended = process.has_ended();
    process.send(SIGKILL);
    const Outcome end = process.wait();
    EXPECT_TRUE(!had_ended || end.exit_code == 0) << end.err;
    return !had_ended;
  }
  /// What lies beside the output.
  std::set<std::string> left() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      if (const std::string name = entry.path().filename(); name.find("out.h5") != std::string::npos)
        names.insert(name);
    return names;
  }
  Folder folder_;
  /// Of the run that is under way.
  bool has_rows() const {
    try {
      return results::read(out_ + ".part").runs.at(0).time.size() > 0;
    } catch (const std::exception&) {
      return false;
    }
  }

  std::string mechanism_, out_ = folder_ / "out.h5";
};

// The unbroken run keeps checkpoints as well: without them it tells the integrator's share of its error, which needs all
// of its steps.
TEST_F(Checkpoint, AKilledRunThatGoesOnGivesTheResultsOfAnUnbrokenOne) {
  const Outcome whole = run("flexura", words({"-o", folder_ / "whole.h5", "-q", "--checkpoint", "1 h"}));
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  int cuts = 0;
  bool cut = true;
  for (int k = 0; cut && k < 4; ++k) {
    std::vector<std::string> more{"-q", "-o", out_, "--checkpoint", "5 ms"};
    if (k > 0) more.push_back("--continue");
    Background process("flexura", words(more));
    cut = killed(process, 13 * k);
    cuts += cut;
    if (cut) EXPECT_FALSE(fs::exists(out_));
  }
  EXPECT_GT(cuts, 0);
  if (cut) {
    const Outcome rest = run("flexura", words({"--continue"
                                               "=" +
                                                   out_,
                                               "-q"}));
    ASSERT_EQ(rest.exit_code, 0) << rest.err;
  }
  EXPECT_TRUE(contents(out_) == contents(folder_ / "whole.h5"));
  // Of the checkpoints nothing is left, and of the killed processes at most their locks, which nobody holds.
  for (const std::string& name : left()) EXPECT_TRUE(name == "out.h5" || name.ends_with(".lock")) << name;
}

TEST_F(Checkpoint, ARunThatWasToldToEndGoesOnToo) {
  ASSERT_EQ(run("flexura", words({"-o", folder_ / "whole.h5", "-q", "--checkpoint", "1 h"})).exit_code, 0);
  Background process("flexura", words({"-q", "-o", out_, "--checkpoint", "5 ms"}));
  ASSERT_TRUE(wait_for([&] { return fs::exists(out_ + ".checkpoint"); }));
  process.send(SIGTERM);
  const Outcome ended = process.wait();
  ASSERT_EQ(ended.exit_code, 1) << ended.err;
  EXPECT_TRUE(fs::exists(out_));
  const Outcome rest = run("flexura", {"simulate", "-q", "-o", out_, "--continue", mechanism_});
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_TRUE(contents(out_) == contents(folder_ / "whole.h5"));
}

TEST_F(Checkpoint, DamagedAndForeignOnesAreRefusedOrTheOneBeforeIsTaken) {
  Background process("flexura", words({"-q", "-o", out_, "--checkpoint", "2 ms"}));
  ASSERT_TRUE(wait_for([&] { return fs::exists(out_ + ".checkpoint.before"); }));
  process.send(SIGKILL);
  process.wait();
  const auto refused = [&](const std::vector<std::string>& more, const std::string& why) {
    const Outcome outcome = run("flexura", words(more));
    EXPECT_EQ(outcome.exit_code, 2) << why;
    EXPECT_THAT(outcome.err, HasSubstr(why));
    EXPECT_FALSE(fs::exists(out_));
  };
  refused({"-o", out_, "--continue", "--set", "solver.tolerance=1e-5"}, "--set differs");
  refused({"-o", out_, "--continue", "--no-estimate"}, "options differ");
  refused({"-o", folder_ / "other.h5", "--continue"}, "there is no checkpoint to go on from");
  refused({"-o", folder_ / "other.h5", "--continue", out_ + ".checkpoint"}, "leave -o");
  refused({"-o", out_, "--checkpoint", "soon"}, "it must be a time above 0");
  refused({"-o", out_, "--checkpoint", "0 s"}, "it must be a time above 0");
  const std::string text = read_text(mechanism_);
  folder_.write("m.toml", replaced(text, "mass = 1", "mass = 2"));
  refused({"-o", out_, "--continue"}, "mechanism file or a file that it names differs");
  folder_.write("m.toml", text);

  // One digit, then the file cut short, then the rows.
  const std::string newest = read_text(out_ + ".checkpoint");
  std::string damaged = newest;
  damaged[damaged.size() / 2] = damaged[damaged.size() / 2] == '1' ? '2' : '1';
  folder_.write("out.h5.checkpoint", damaged);
  const std::string before = read_text(out_ + ".checkpoint.before");
  folder_.write("out.h5.checkpoint.before", before.substr(0, before.size() / 2));
  refused({"-o", out_, "--continue"}, "there is no checkpoint to go on from");
  folder_.write("out.h5.checkpoint.before", before);
  const std::string rows = read_text(out_ + ".checkpoint.rows");
  folder_.write("out.h5.checkpoint.rows", rows.substr(0, 100));
  refused({"-o", out_, "--continue"}, "are damaged or of another run");
  folder_.write("out.h5.checkpoint.rows", rows);
  const Outcome outcome = run("flexura", words({"-o", out_, "--continue"}));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("going on from the checkpoint before"));
}

// The rows of an ended run can be read at any moment, also by h5py without h5clear (its swmr = True),
// whatever killed the program.
TEST_F(Checkpoint, RowsOfAKilledRunAreReadable) {
  for (int k = 0; k < 4; ++k) {
    Background process("flexura", words({"-q", "-o", out_}));
    ASSERT_TRUE(wait_for([&] { return process.has_ended() || has_rows(); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(11 * k));
    process.send(SIGKILL);
    if (process.wait().exit_code == 0) continue;
    EXPECT_GT(results::read(out_ + ".part").runs.at(0).time.size(), 0);
    fs::remove(out_ + ".part");
  }
}

// The most delicate moments are those between two runs, when groups are made: of 33 kills of these sixty
// short runs nine left a file that could not be read.
TEST_F(Checkpoint, RowsOfEndedRunsAreReadableWhereverTheNextWasCut) {
  std::string text = R"toml(
[body.ball]
mass = 1
[joint.guide]
type = "prismatic"
from = "ground"
to = "ball"
[solver]
end_time = "0.1 s"
output_step = "5 ms"
)toml";
  for (int i = 0; i < 60; ++i) text += "[run.r" + std::to_string(i) + "]\nset = []\n";
  const std::string mechanism = folder_.write("many.toml", text);
  int n_cut = 0;
  for (int k = 0; k < 12; ++k) {
    Background process("flexura", {"simulate", mechanism, "-q", "-o", out_});
    ASSERT_TRUE(wait_for([&] { return process.has_ended() || has_rows(); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(17 * k));
    process.send(SIGKILL);
    if (process.wait().exit_code == 0) continue;
    const results::Results left = results::read(out_ + ".part");
    for (std::size_t i = 0; i + 1 < left.runs.size(); ++i) EXPECT_TRUE(left.runs[i].complete);
    n_cut += left.runs.size() > 1;
    fs::remove(out_ + ".part");
  }
  EXPECT_GT(n_cut, 0);
}

// A state file's numbers are checked before an integrator takes them: without its checksum nothing goes on,
// and with a checksum made anew a deleted entry is refused.
TEST_F(Checkpoint, AStateFileThatWasChangedIsNoHistory) {
  const std::string state = folder_ / "state.json";
  ASSERT_EQ(run("flexura", words({"--run", "second", "-q", "-o", out_, "--set", "solver.stop_time=\"0.1 s\"",
                                  "--save-state", state}))
                .exit_code,
            0);
  const Json good = Json::parse(read_text(state));
  const auto go_on = [&](Json changed, bool with_checksum) {
    if (with_checksum) {
      changed.erase("checksum");
      changed["checksum"] = input::ContentHash().add(changed.dump()).hex();
    }
    folder_.write("changed.json", changed.dump(1));
    return run("flexura", words({"--run", "second", "-q", "-o", folder_ / "rest.h5", "--set",
                                 "solver.end_time=\"0.2 s\"", "--continue", folder_ / "changed.json"}));
  };
  EXPECT_EQ(go_on(good, true).exit_code, 0) << go_on(good, true).err;
  EXPECT_EQ(go_on(good, false).exit_code, 0);
  Json other = good;
  other["continuation"]["next_row"] = -5;
  EXPECT_THAT(go_on(other, false).err, HasSubstr("its checksum does not fit"));
  EXPECT_THAT(go_on(other, true).err, HasSubstr("the next row is said to be number -5"));
  EXPECT_EQ(go_on(other, true).exit_code, 2);
  other = good;
  other.erase("checksum");
  EXPECT_THAT(go_on(other, false).err, HasSubstr("it has no checksum"));
  const std::size_t n = good["continuation"]["history"].size();
  for (std::size_t i = 0; i < n; i += n / 8) {
    other = good;
    other["continuation"]["history"].erase(i);
    const Outcome outcome = go_on(other, true);
    EXPECT_EQ(outcome.exit_code, 2) << i << ": " << outcome.err;
  }
  for (const char* const key : {"positions", "switches", "time"}) {
    other = good;
    other.erase(key);
    EXPECT_EQ(go_on(other, true).exit_code, 2) << key;
  }
  const Outcome heavier = run("flexura", words({"--run", "second", "-q", "-o", folder_ / "rest.h5", "--set",
                                                "body.ball.mass=2", "--continue", state}));
  EXPECT_EQ(heavier.exit_code, 2);
  EXPECT_THAT(heavier.err, HasSubstr("was saved by another mechanism"));
  for (const char* const key : {"method", "v_dot", "energy", "next_row", "history", "signature"}) {
    other = good;
    other["continuation"].erase(key);
    EXPECT_EQ(go_on(other, true).exit_code, 2) << key;
  }
}

}  // namespace
}  // namespace flexura::test
