// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "mbs/base/hdf5/file.hpp"
#include "mbs/results/results.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/mbs/solver/run_folder.hpp"

/// States in files, cut and continued runs, prescribed motion, sequences of equilibria and linear systems,
/// through the program.
namespace flexura::mbs::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class States : public RunFolder {};
class Sequences : public RunFolder {};
class LinearFiles : public RunFolder {};

const results::Quantity* find(const results::Run& run, const std::string& name, int& at) {
  for (std::size_t i = 0; i < run.quantities.size(); ++i)
    if (run.quantities[i].name == name) {
      at = static_cast<int>(i);
      return &run.quantities[i];
    }
  return nullptr;
}

TEST_F(States, RunCutInTwoIsTheUnbrokenRunRowByRow) {
  file(rod + "[solver]\nend_time = 2\noutput_step = 0.05\ntolerance = 1e-8\nstore_states = true\n");
  ASSERT_EQ(flexura("simulate m.toml -o whole.h5"), 0) << text_of("err.txt");
  EXPECT_EQ(flexura("simulate m.toml -o first.h5 --set solver.stop_time=1 --save-state half.json"), 0);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("stop_time is reached"));
  ASSERT_EQ(flexura("simulate m.toml -o second.h5 --continue half.json"), 0) << text_of("err.txt");
  const results::Run whole = results::read(folder_ / "whole.h5").runs[0],
                     first = results::read(folder_ / "first.h5").runs[0],
                     second = results::read(folder_ / "second.h5").runs[0];
  ASSERT_EQ(first.time.size() + second.time.size(), whole.time.size());
  const auto n = first.time.size();
  EXPECT_EQ(first.values, whole.values.topRows(n));
  EXPECT_EQ(second.values, whole.values.bottomRows(second.time.size()));
  EXPECT_EQ(second.states, whole.states.bottomRows(second.time.size()));

  EXPECT_EQ(flexura("simulate m.toml -o x.h5 --continue half.json --set solver.method=runge_kutta"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("the integrator \"ida\""));

  // Another mechanism with states of the same names: a constraint more, then another one's history.
  file(rod + R"toml([body.rod.marker.tip]
position = [1, 0, 0]
[ground.marker.wall]
position = [1, -1, 0]
[constraint.link]
type = "distance"
from = "ground.wall"
to = "rod.tip"
length = "1 m"
)toml",
       "other.toml");
  EXPECT_EQ(flexura("simulate other.toml -o x.h5 --continue half.json"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("was saved by another mechanism"));
  std::string state = text_of("half.json");
  const auto history = state.find("\"history\": [");
  ASSERT_NE(history, std::string::npos);
  file(state.substr(0, history) + "\"history\": [1e9, 2]}}", "short.json");
  EXPECT_EQ(flexura("simulate m.toml -o x.h5 --continue short.json"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("was changed after it was written"));
  file(state.substr(0, history), "cut.json");
  EXPECT_EQ(flexura("simulate m.toml -o x.h5 --continue cut.json"), 2);
  EXPECT_THAT(text_of("err.txt"),
              AllOf(HasSubstr("is not a state file: parse error"), Not(HasSubstr("json.exception"))));
  EXPECT_EQ(flexura("simulate none.toml -o x.h5"), 2);
  file("", "empty.toml");
  EXPECT_EQ(flexura("simulate empty.toml -o x.h5"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("empty.toml: has no body and no control"));
}

TEST_F(States, StateSetChangesTheStatesThatItNames) {
  file(rod);
  file(R"({"format": "flexura state", "time": 0.5, "velocities": {"hinge.speed": 3}})", "set.json");
  ASSERT_EQ(flexura("assemble m.toml --from-state set.json --save-state all.json"), 0) << text_of("err.txt");
  EXPECT_THAT(text_of("out.txt"), AllOf(HasSubstr("t = 0.5 s"), HasSubstr("0.34906585"), HasSubstr(" 3 ")));
  EXPECT_THAT(text_of("all.json"), AllOf(HasSubstr("\"hinge.speed\": 3.0"), HasSubstr("\"time\": 0.5")));
  file(R"({"format": "flexura state", "velocities": {"hinge.sped": 3}})", "wrong.json");
  EXPECT_EQ(flexura("assemble m.toml --from-state wrong.json"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("no state \"hinge.sped\", did you mean \"hinge.speed\"?"));
  EXPECT_EQ(flexura("assemble m.toml --from-state m.toml"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("m.toml: is not a state file"));
  EXPECT_EQ(flexura("simulate m.toml --continue set.json -o x.h5"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("no history"));
}

TEST_F(States, OutputsFollowAfterwardsFromStoredStates) {
  const std::string solver = "[solver]\nend_time = 1\noutput_step = 0.1\n";
  file(rod + solver + "store_states = true\n[output]\nquantities = [\"hinge.angle\"]\n");
  ASSERT_EQ(flexura("simulate m.toml -o m.h5"), 0) << text_of("err.txt");
  ASSERT_EQ(flexura("outputs m.toml m.h5 --quantity hinge.force_* hinge.acceleration -o o.h5 --csv"), 0)
      << text_of("err.txt");
  const results::Run run = results::read(folder_ / "m.h5").runs[0],
                     after = results::read(folder_ / "o.h5").runs[0];
  int angle = -1, force = -1, acceleration = -1, balance = -1;
  ASSERT_NE(find(run, "hinge.angle", angle), nullptr);
  ASSERT_NE(find(after, "hinge.force_x", force), nullptr);
  ASSERT_NE(find(after, "hinge.acceleration", acceleration), nullptr);
  ASSERT_NE(find(after, "energy.balance", balance), nullptr);
  EXPECT_EQ(run.time, after.time);
  for (int k = 0; k <= 10; ++k) {
    // J phi'' = -m g c cos(phi); the force on the rod along x is m c (-phi'' sin(phi) - phi'^2 cos(phi)),
    // with phi' from the energy.
    const double phi = run.values(k, angle), a = -1.5 * 9.81 * std::cos(phi);
    const double w2 = 3.0 * 9.81 * (std::sin(M_PI / 9) - std::sin(phi));
    EXPECT_NEAR(after.values(k, acceleration), a, 1e-10);
    // phi' of the run is right to the tolerance of 1e-6 in each of some hundred steps.
    EXPECT_NEAR(after.values(k, force), -a * std::sin(phi) - w2 * std::cos(phi), 1e-3);
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "o.run.csv"));
  EXPECT_EQ(flexura("outputs m.toml m.h5 -o m.h5"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("is read by this command"));
  file(rod + solver);
  ASSERT_EQ(flexura("simulate m.toml -o n.h5"), 0);
  EXPECT_EQ(flexura("outputs m.toml n.h5"), 2);
  EXPECT_THAT(text_of("err.txt"),
              HasSubstr("no states stored; simulate with --set solver.store_states=true"));
}

TEST_F(Sequences, KinematicsGivesTheDrivesTorqueOfTheTurningRod) {
  // The drive gives the angle.
  file(rod.substr(0, rod.find("angle = ")) + R"toml(
drive = "pi/9 + 2*t"
[solver]
method = "kinematics"
end_time = 1
output_step = 0.1
)toml");
  ASSERT_EQ(flexura("simulate m.toml -o m.h5"), 0) << text_of("err.txt");
  const results::Run run = results::read(folder_ / "m.h5").runs[0];
  int angle = -1, work = -1, balance = -1;
  ASSERT_NE(find(run, "hinge.angle", angle), nullptr);
  ASSERT_NE(find(run, "energy.input", work), nullptr);
  ASSERT_NE(find(run, "energy.balance", balance), nullptr);
  ASSERT_EQ(run.time.size(), 11);
  for (int k = 0; k <= 10; ++k) {
    EXPECT_NEAR(run.values(k, angle), M_PI / 9 + 2 * run.time(k), 1e-12);
    // At a constant speed the drive pays for the lifting alone; Lobatto's rule of degree 5 over strides of
    // 0.2 rad leaves (0.2)^6 / 1e4 of it.
    EXPECT_NEAR(run.values(k, work), 9.81 * (std::sin(run.values(k, angle)) - std::sin(M_PI / 9)), 1e-7);
    EXPECT_NEAR(run.values(k, balance), 0.0, 1e-7);
  }
  file(rod + "[solver]\nmethod = \"kinematics\"\n");
  EXPECT_EQ(flexura("simulate m.toml -o x.h5"), 2);
  EXPECT_THAT(text_of("err.txt"), AllOf(HasSubstr("hinge.speed"), HasSubstr("drive it")));
}

// However far the rows lie apart: x = 0.8 + 0.15 sin 3t, and x' = 1 - x.
TEST_F(Sequences, KinematicsIntegratesDrivenSpeedsToTheTolerance) {
  const auto scene = [](const char* speed, const char* step) {
    return fmt::format(R"toml(
gravity = [0, 0, 0]
[ground.marker.rail]
axis = [1, 0, 0]
[body.b]
mass = 1
inertia = [1, 1, 1]
[body.b.marker.rail]
axis = [1, 0, 0]
[joint.d]
type = "prismatic"
from = "ground.rail"
to = "b.rail"
position = 0.8
drive_speed = "{}"
[solver]
method = "kinematics"
tolerance = 1e-8
end_time = 1
output_step = {}
[output]
quantities = ["d.position"]
)toml",
                       speed, step);
  };
  for (const char* step : {"0.2", "0.05"})
    for (const bool follows : {false, true}) {
      file(scene(follows ? "1 - d.position" : "0.45*cos(3*t)", step));
      ASSERT_EQ(flexura("simulate m.toml -o m.h5"), 0) << text_of("err.txt");
      // Where lines are broken depends on the numbers before.
      EXPECT_THAT(text_of("out.txt"), ::testing::ContainsRegex("driven[[:space:]]+speeds[[:space:]]+are"));
      const results::Run run = results::read(folder_ / "m.h5").runs[0];
      for (Eigen::Index k = 0; k < run.time.size(); ++k) {
        const double t = run.time(k), x = follows ? 1.0 - 0.2 * std::exp(-t) : 0.8 + 0.15 * std::sin(3.0 * t);
        // The tolerance in each of some hundred steps.
        EXPECT_NEAR(run.values(k, 0), x, 3e-6) << t;
      }
    }
}

// The rows between the ends of a step, which the energy account wants, lie before a jump: 200 of them in 25 runs.
TEST_F(Sequences, KinematicsPassesJumpsOfDrivenSpeeds) {
  constexpr double kTolerance = 1e-6;
  const auto slide = [](int i, const std::string& speed) {
    return fmt::format(
        "[body.b{0}]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j{0}]\ntype = \"prismatic\"\nfrom = \"ground\"\n"
        "to = \"b{0}\"\ndrive_speed = \"{1}\"\n",
        i, speed);
  };
  struct Jump {
    double t, before, after;
  };
  chance::Chance chance(20261128);
  for (int trial = 0; trial < 25; ++trial) {
    const double w = chance.between(5.0, 40.0);
    std::vector<Jump> jumps;
    std::string text = "gravity = [0, 0, 0]\n" + slide(0, fmt::format("3*sin({:.17g}*t)", w));
    for (int i = 1; i <= 8; ++i) {
      jumps.push_back(
          {chance.between(0.02, 0.98), chance.either_sign(0.2, 3.0), chance.either_sign(0.2, 3.0)});
      const Jump& jump = jumps.back();
      text += slide(i, fmt::format("t < {:.17g} ? {:.17g} : {:.17g}", jump.t, jump.before, jump.after));
    }
    file(text +
         fmt::format("[solver]\nmethod = \"kinematics\"\ntolerance = {}\nend_time = 1\noutput_step = {}\n"
                     "[output]\nquantities = [\"j*.position\"]\n",
                     kTolerance, chance.one_of({0.5, 0.25, 0.1})));
    ASSERT_EQ(flexura("simulate m.toml -o m.h5 --no-estimate"), 0) << trial << ": " << text_of("err.txt");
    const results::Run run = results::read(folder_ / "m.h5").runs[0];
    ASSERT_EQ(run.quantities[8].name, "j8.position");
    // Two halves of a step h err by x''' h^3 / 24, at most the tolerance; twice h would err by more. Rows and jumps end some steps.
    const double steps = 2.0 * std::cbrt(3.0 * w * w / (24.0 * kTolerance)) + 20.0;
    for (Eigen::Index k = 0; k < run.time.size(); ++k) {
      const double t = run.time(k);
      EXPECT_NEAR(run.values(k, 0), 3.0 / w * (1.0 - std::cos(w * t)), kTolerance * steps) << trial;
      for (std::size_t i = 0; i < jumps.size(); ++i) {
        const Jump& jump = jumps[i];
        // Steps of constant speed are exact.
        EXPECT_NEAR(run.values(k, static_cast<Eigen::Index>(i + 1)),
                    jump.before * std::min(t, jump.t) + jump.after * std::max(t - jump.t, 0.0), 1e-12)
            << trial;
      }
    }
  }
}

TEST_F(Sequences, QuasiStaticsFollowsAGrowingTorque) {
  // From straight down: 2 g 0.5 sin(phi) = T(t).
  file(rod + R"toml(
[force.wind]
type = "joint_force"
joint = "hinge"
value = "5*t"
[solver]
method = "quasi_statics"
end_time = 1
output_step = 0.25
)toml");
  ASSERT_EQ(flexura("simulate m.toml -o m.h5"), 0) << text_of("err.txt");
  const results::Run run = results::read(folder_ / "m.h5").runs[0];
  int angle = -1;
  ASSERT_NE(find(run, "hinge.angle", angle), nullptr);
  ASSERT_EQ(run.time.size(), 5);
  for (int k = 0; k < 5; ++k)
    EXPECT_NEAR(run.values(k, angle), -0.5 * M_PI + std::asin(5 * run.time(k) / 9.81), 1e-8);
}

TEST_F(LinearFiles, EveryFormatHoldsTheSameSystem) {
  file(rod);
  const std::string about = "linearize m.toml --equilibrium --input hinge.speed --measure hinge.angle ";
  ASSERT_EQ(flexura(about + "-o a.m --response 0.1:10:21"), 0) << text_of("err.txt");
  ASSERT_EQ(flexura(about + "-o a.h5"), 0) << text_of("err.txt");
  ASSERT_EQ(flexura(about + "-o a.mtx"), 0) << text_of("err.txt");
  // x = (angle, speed), A = [0 1; -3 g / 2 l, 0], B = [0; 1 / J].
  const hdf5::File in(folder_ / "a.h5", hdf5::Mode::read);
  const Eigen::MatrixXd A = hdf5::read_matrix(in.root(), "A", 2, 2),
                        B = hdf5::read_matrix(in.root(), "B", 2, 1);
  EXPECT_NEAR(A(1, 0), -1.5 * 9.81, 1e-6);
  EXPECT_NEAR(B(1, 0), 1.5, 1e-9);
  const std::string market = text_of("a_A.mtx");
  EXPECT_THAT(market,
              AllOf(HasSubstr("%%MatrixMarket matrix coordinate real general"), HasSubstr("2 1 -14.71")));
  EXPECT_THAT(text_of("a.m"), HasSubstr("-14.71"));
  // At 0.1 Hz: 1 / (k - J w^2), k = 9.81.
  const double w = 0.2 * M_PI, H = 1.0 / (9.81 - w * w / 1.5);
  std::istringstream response(text_of("a_response.csv"));
  std::string line;
  std::getline(response, line);
  std::getline(response, line);
  double f = 0.0, size = 0.0, phase = 0.0;
  ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf", &f, &size, &phase), 3);
  EXPECT_NEAR(f, 0.1, 1e-12);
  EXPECT_NEAR(size, H, 1e-6 * H);
  EXPECT_EQ(flexura(about + "-o a.txt"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr(".mtx (Matrix Market)"));
  EXPECT_EQ(flexura(about + "--response 1:0.1:5"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("FROM:TO:COUNT"));
}

TEST_F(LinearFiles, OctaveReadsTheScriptAndTheDescriptorSystem) {
  if (std::system("command -v octave-cli > /dev/null 2>&1") != 0) GTEST_SKIP() << "octave is not installed";
  file(rod);
  ASSERT_EQ(flexura("linearize m.toml --equilibrium -o a.m"), 0) << text_of("err.txt");
  ASSERT_EQ(flexura("linearize m.toml --equilibrium --descriptor -o e.m"), 0) << text_of("err.txt");
  std::ofstream(folder_ / "test.m") << "a; w = max(abs(eig(A))); e; v = max(abs(eig(A, E)));\n"
                                       "if abs(w^2 - 14.715) > 1e-5 || abs(v - w) > 1e-5, exit(3), end\n";
  const std::string command =
      "cd " + folder_.string() + " && octave-cli --no-init-file test.m > out.txt 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 0) << text_of("out.txt");
}

}  // namespace
}  // namespace flexura::mbs::test
