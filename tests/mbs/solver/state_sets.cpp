// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <cmath>

#include "mbs/results/results.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/solver/run_folder.hpp"

/// State sets of a mechanism file: what they name, what they leave, runs that start from them.
namespace flexura::mbs::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class StateSets : public RunFolder {
 protected:
  double start_of(const std::string& run, const std::string& quantity) const {
    for (const results::Run& r : results::read(folder_ / "o.h5").runs)
      for (std::size_t i = 0; r.name == run && i < r.quantities.size(); ++i)
        if (r.quantities[i].name == quantity) return r.values(0, static_cast<Eigen::Index>(i));
    ADD_FAILURE() << run << ": " << quantity;
    return 0.0;
  }
};

const std::string short_run = "[solver]\nend_time = 1\noutput_step = 0.5\n";

TEST_F(StateSets, EachRunStartsFromItsSet) {
  file(rod + short_run + R"toml(
[parameters]
half = "pi/2"
[state.up]
values = { hinge.angle = "half", "hinge.speed" = "30 deg/s" }
[state.fast]
values.hinge.speed = 2
[state.rest]
equilibrium = true
values.hinge.angle = -1.3
[state.spun]
equilibrium = true
values = { hinge.angle = -1.3, hinge.speed = 3 }
[run.given]
[run.up]
state = "up"
[run.fast]
state = "fast"
[run.rest]
state = "rest"
[run.spun]
state = "spun"
[run.zero]
state = "zero"
)toml");
  ASSERT_EQ(flexura("simulate m.toml -o o.h5 --no-estimate"), 0) << text_of("err.txt");
  const struct {
    const char* run;
    double angle, speed;
  } right[] = {{"given", M_PI / 9, 0}, {"up", M_PI / 2, M_PI / 6}, {"fast", M_PI / 9, 2},
               {"rest", -M_PI / 2, 0}, {"spun", -M_PI / 2, 3},     {"zero", 0, 0}};
  for (const auto& r : right) {
    // The equilibrium is found to 1e-9 of the load; the others are the numbers given.
    EXPECT_NEAR(start_of(r.run, "hinge.angle"), r.angle, 1e-9) << r.run;
    EXPECT_NEAR(start_of(r.run, "hinge.speed"), r.speed, 1e-12) << r.run;
  }
  // The command line has the last word.
  ASSERT_EQ(flexura("assemble m.toml --run up --state fast"), 0) << text_of("err.txt");
  EXPECT_THAT(text_of("out.txt"), AllOf(HasSubstr("0.34906585"), HasSubstr(" 2 ")));
  ASSERT_EQ(flexura("assemble m.toml --state up --set state.up.values.hinge.speed=7"), 0)
      << text_of("err.txt");
  EXPECT_THAT(text_of("out.txt"), AllOf(HasSubstr("1.57079633"), HasSubstr(" 7 ")));
}

// 0 is a time as any other; stop_time = 0 is none.
TEST_F(StateSets, ARunMayStartBeforeZero) {
  file(rod + "[state.early]\ntime = -0.4\nvalues.hinge.speed = 1\n" + short_run);
  ASSERT_EQ(flexura("simulate m.toml -o o.h5 --state early --no-estimate"), 0) << text_of("err.txt");
  const results::Run run = results::read(folder_ / "o.h5").runs[0];
  EXPECT_EQ(run.time(0), -0.4);
  EXPECT_EQ(run.time(run.time.size() - 1), 1.0);
}

TEST_F(StateSets, RunFromASavedStateIsTheRestOfTheOneThatSavedIt) {
  file(rod + "[state.half]\nfile = \"half.json\"\n" +
       "[solver]\nend_time = 1\noutput_step = 0.5\ntolerance = 1e-10\n");
  ASSERT_EQ(flexura("simulate m.toml -o o.h5 --no-estimate"), 0) << text_of("err.txt");
  const double angle = results::read(folder_ / "o.h5").runs[0].values(2, 0);
  ASSERT_EQ(results::read(folder_ / "o.h5").runs[0].time(2), 1.0);
  ASSERT_EQ(
      flexura("simulate m.toml -o x.h5 --set solver.stop_time=0.5 --save-state half.json --no-estimate"), 0);
  ASSERT_EQ(flexura("simulate m.toml -o o.h5 --state half --no-estimate"), 0) << text_of("err.txt");
  const results::Run rest = results::read(folder_ / "o.h5").runs[0];
  const double start = rest.time(0);  // of the step that passed 0.5 s
  EXPECT_GE(start, 0.5);
  EXPECT_LT(start, 0.6);
  // Both to the tolerance of 1e-10 in each of some hundred steps.
  EXPECT_NEAR(rest.values(rest.time.size() - 1, 0), angle, 1e-7);
}

// A flexible pendulum that a spring holds.
const std::string pendulum = R"toml(
gravity = [0, -9.81, 0]
[body.beam]
superelement = "beam.se.h5"
modes = 3
[joint.j]
type = "revolute"
from = "ground"
to = "beam.left"
[force.spring]
type = "joint_spring"
joint = "j"
stiffness = "1 kN*m/rad"
)toml";

TEST_F(StateSets, RigidRunsStartFromFlexibleStatesAndBack) {
  superelement::write(folder_ / "beam.se.h5", lattice::make_lattice(4, 40.0).se);
  file(pendulum + R"toml(
[state.rest]
file = "rest.json"
[state.stiff]
file = "stiff.json"
[state.typed]
values = { beam.mode_1 = 0.001, beam.mode_1_rate = 0.2, j.angle = 0.1 }
[run.flexible]
[run.rigid]
set = ["body.beam.fidelity=rigid"]
)toml" +
       short_run);
  ASSERT_EQ(flexura("statics m.toml --run flexible --save-state rest.json"), 0) << text_of("err.txt");
  ASSERT_THAT(text_of("rest.json"), HasSubstr("beam.mode_3_rate"));
  ASSERT_EQ(flexura("assemble m.toml --run rigid --state rest --save-state stiff.json"), 0)
      << text_of("err.txt");
  EXPECT_THAT(
      text_of("out.txt") + text_of("err.txt"),
      HasSubstr("state \"rest\": 6 states of \"beam\" left out, which its fidelity here does not have"));
  EXPECT_THAT(text_of("stiff.json"), Not(HasSubstr("mode")));
  const auto angle_in = [&](const char* name) {
    const std::string text = text_of(name);
    return std::stod(text.substr(text.find("\"j.angle\": ") + 11));
  };
  EXPECT_EQ(angle_in("stiff.json"), angle_in("rest.json"));
  EXPECT_NE(angle_in("stiff.json"), 0.0);
  ASSERT_EQ(flexura("assemble m.toml --run flexible --state stiff --save-state back.json"), 0)
      << text_of("err.txt");
  EXPECT_THAT(
      text_of("out.txt") + text_of("err.txt"),
      HasSubstr("state \"stiff\": holds no value of 3 modal coordinates of \"beam\"; they start at zero"));
  EXPECT_EQ(angle_in("back.json"), angle_in("rest.json"));
  EXPECT_THAT(text_of("back.json"), HasSubstr("\"beam.mode_1\": 0.0"));
  // Modal coordinates that are set by hand.
  ASSERT_EQ(flexura("assemble m.toml --run flexible --state typed --save-state typed.json"), 0)
      << text_of("err.txt");
  EXPECT_THAT(text_of("typed.json"),
              AllOf(HasSubstr("\"beam.mode_1\": 0.001"), HasSubstr("\"beam.mode_1_rate\": 0.2")));
  // The same file straight from the command line.
  EXPECT_EQ(flexura("assemble m.toml --run rigid --from-state rest.json"), 0) << text_of("err.txt");
}

TEST_F(StateSets, WhatMeansNothingIsRefused) {
  const std::string begin = rod + "[state.a]\n";
  const struct {
    const char *set, *says;
  } wrong[] = {{"values.hinge.angel = 1",
                "m.toml:14: state.a.values.hinge.angel: is none of the mechanism's states; take one that "
                "flexura assemble lists, did you mean \"hinge.angle\"?"},
               {"values.hinge.angle = \"3 mm\"", "is a length, an angle is wanted"},
               {"values.hinge.angle = \"haf*2\"", "haf"},
               {"values.hinge.angle = \"2 grad\"", "has the unknown unit \"grad\""},
               {"values.hinge.angle = \"inf\"", "state.a.values.hinge.angle"},
               {"values.hinge.angle = nan", "state.a.values.hinge.angle"},
               {"values = { hinge.angle = 1, \"hinge.angle\" = 2 }", "gives \"hinge.angle\" twice; keep one"},
               {"file = \"none.json\"", "none.json: there is no such file"},
               {"", "says nothing of any state"}};
  for (const auto& w : wrong) {
    file(begin + w.set + "\n" + short_run);
    EXPECT_EQ(flexura("assemble m.toml --state a"), 2) << w.set;
    EXPECT_THAT(text_of("err.txt"), HasSubstr(w.says));
  }
  // A run of no time at all.
  file(begin + "time = 2\nzero = true\n" + short_run);
  EXPECT_EQ(flexura("simulate m.toml -o o.h5 --state a"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("starts from a state of t = 2 s, behind solver.end_time = 1 s"));
  file(begin + "zero = true\n[run.r]\nstate = \"b\"\n" + short_run);
  EXPECT_EQ(flexura("assemble m.toml"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("run.r.state = \"b\": there is no [state.NAME] of this name"));
  file(rod + "[state.zero]\nvalues.hinge.angle = 1\n");
  EXPECT_EQ(flexura("assemble m.toml"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("is the set with every state zero; choose another name"));
}

}  // namespace
}  // namespace flexura::mbs::test
