// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "mbs/base/documents/content_hash.hpp"
#include "mbs/study/cache/child_process.hpp"
#include "mbs/study/study_file.hpp"
#include "tests/app/command.hpp"

namespace flexura::study {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using test::Outcome;
using test::read_text;
using test::replaced;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// A mass on a spring: x = x_0 cos(omega t) with omega = 10 rad/s.
const char* const kOscillator = R"toml(
gravity = [0, 0, 0]
[ground.marker.rail]
axis = [1, 0, 0]
[body.mass]
mass = "2 kg"
inertia = [1, 1, 1]
[body.mass.marker.pin]
axis = [1, 0, 0]
[joint.slide]
type = "prismatic"
from = "ground.rail"
to = "mass.pin"
position = "0.1 m"
[force.spring]
type = "joint_spring_damper"
joint = "slide"
stiffness = 200
[solver]
end_time = "1 s"
)toml";

const char* const kStudy = R"toml(
mechanism = "oscillator.toml"
repeats = 2
[axis.tolerance]
key = "solver.tolerance"
values = ["1e-3", "1e-5", "1e-7"]
[quantity.position]
of = "slide.position"
[want]
accuracy = ["1 %", "1e-12 %"]
)toml";

std::string refusal(const Folder& folder, const std::string& text) {
  folder.write("oscillator.toml", kOscillator);
  try {
    read_study(folder.write("study.toml", text));
  } catch (const input::InputError& e) {
    return e.what();
  }
  return "accepted";
}

StudyFile read(const Folder& folder, const std::string& text) {
  folder.write("oscillator.toml", kOscillator);
  return read_study(folder.write("study.toml", text));
}

std::vector<std::string> names(const StudyFile& study) {
  std::vector<std::string> out;
  for (const Choice& choice : study.choices) out.push_back(choice.name);
  return out;
}

const std::string kTwoAxes = replaced(kStudy, "[quantity.position]", R"toml(
[axis.order.choice.two]
set = ["solver.max_order=2"]
[axis.order.choice.five]
set = ["solver.max_order=5"]
[quantity.position])toml");

TEST(StudyFile, ProductRunsAllCombinationsAndEndsWithTheFinest) {
  const Folder folder;
  EXPECT_THAT(names(read(folder, kTwoAxes)),
              ElementsAre("tolerance 1e-3, two", "tolerance 1e-3, five", "tolerance 1e-5, two",
                          "tolerance 1e-5, five", "tolerance 1e-7, two", "tolerance 1e-7, five"));
}

TEST(StudyFile, OneAtATimeLeavesTheOtherAxesAtTheirFinest) {
  const Folder folder;
  EXPECT_THAT(names(read(folder, "ladder = \"one_at_a_time\"\n" + kTwoAxes)),
              ElementsAre("tolerance 1e-3, five", "tolerance 1e-5, five", "tolerance 1e-7, two",
                          "tolerance 1e-7, five"));
}

TEST(StudyFile, WhatTheProgramChoosesStandsBeforeTheLadder) {
  const Folder folder;
  const StudyFile study = read(folder, replaced(kStudy, "[want]", "[want]\nchosen = true"));
  ASSERT_EQ(study.choices.size(), 5u);
  EXPECT_EQ(study.choices[0].name, "chosen for 1 %");
  EXPECT_DOUBLE_EQ(study.choices[0].wanted, 0.01);
  EXPECT_EQ(study.choices[0].set.front(), "solver.accuracy=0.01");
  EXPECT_EQ(study.choices.back().wanted, 0.0);
  EXPECT_THAT(refusal(folder, replaced(kStudy, "\"1e-12 %\"", "\"0 %\"")), HasSubstr("must be above 0"));
}

TEST(StudyFile, RichardsonShareOfAReferenceCheck) {
  const Folder folder;
  const StudyFile study = read(folder, std::string(kStudy) + R"toml(
[reference]
set = ["solver.tolerance=1e-11"]
[reference.check.mesh]
set = ["solver.tolerance=1e-9"]
ratio = 2
order = 2
)toml");
  ASSERT_EQ(study.checks.size(), 1u);
  EXPECT_DOUBLE_EQ(study.checks[0].share, 1.0 / 3.0);  // 1 / (2^2 - 1)
  EXPECT_EQ(study.checks[0].choice.set.back(), "solver.tolerance=1e-9");
}

TEST(StudyFile, RefusalsNameValueRuleAndRemedy) {
  const Folder folder;
  EXPECT_THAT(refusal(folder, replaced(kStudy, "oscillator.toml", "none.toml")),
              HasSubstr("mechanism = \"none.toml\": there is no such file; give the mechanism file's path"));
  EXPECT_THAT(refusal(folder, replaced(kStudy, "values = [\"1e-3\", \"1e-5\", \"1e-7\"]", "")),
              HasSubstr("an axis without choices; give at least one value"));
  EXPECT_THAT(refusal(folder, replaced(kStudy, "key = \"solver.tolerance\"", "")),
              HasSubstr("either a key with values or choices by name"));
  EXPECT_THAT(refusal(folder, replaced(kStudy, "solver.tolerance\"", "part.rod.mesh.size\"")),
              HasSubstr("there is no [part.rod]"));
  EXPECT_THAT(refusal(folder, replaced(kStudy, "[quantity.position]", "[quantiy.position]")),
              HasSubstr("did you mean \"quantity\"?"));
  EXPECT_THAT(refusal(folder, replaced(kStudy, "of = \"slide.position\"", "norm = \"maximum\"")),
              HasSubstr("norm"));
  EXPECT_THAT(refusal(folder, std::string(kStudy) + "[reference]\nset = [\"solver.tolerance=1e-11\"]\n"),
              HasSubstr("nothing says how far the reference is converged"));
}

TEST(Child, IsMeasuredAndEndedAtItsTimeLimit) {
  const Folder folder;
  const ChildOutcome done =
      run_child({"/bin/sh", "-c", "sleep 0.2; echo out; echo err >&2; exit 3"}, folder.path());
  EXPECT_EQ(done.exit_code, 3);
  EXPECT_EQ(done.out, "out\n");
  EXPECT_EQ(done.err, "err\n");
  EXPECT_GE(done.wall, 0.2);  // sleeping takes wall time
  EXPECT_LT(done.cpu, 0.15);  // and no processor
  EXPECT_GT(done.peak_memory, 1e5);
  const ChildOutcome late = run_child({"/bin/sleep", "60"}, folder.path(), {0.1});
  EXPECT_TRUE(late.timed_out);
  EXPECT_LT(late.wall, 30.0);
  // Of processor time sleep takes none; by the clock it is ten times as much.
  EXPECT_FALSE(run_child({"/bin/sleep", "0.4"}, folder.path(), {0.2, true}).timed_out);
  EXPECT_TRUE(run_child({"/bin/sleep", "60"}, folder.path(), {0.02, true}).timed_out);
  const ChildOutcome busy = run_child({"/bin/sh", "-c", "while :; do :; done"}, folder.path(), {0.3, true});
  EXPECT_TRUE(busy.timed_out);
  EXPECT_GT(busy.cpu, 0.25);
  EXPECT_THROW(run_child({"/no/such/program"}, folder.path()), std::runtime_error);
}

TEST(ContentHash, FollowsTheFilesThatAnInputFileNames) {
  const Folder folder;
  folder.write("part.step", "one");
  const fs::path file = folder.write("part.toml", "file = \"part.step\"\n");
  const std::string before = input::ContentHash().add_input_file(file).hex();
  EXPECT_EQ(before, input::ContentHash().add_input_file(file).hex());
  folder.write("part.step", "two");
  EXPECT_NE(before, input::ContentHash().add_input_file(file).hex());
  // What a subsystem, a part or a deck names counts as well.
  const auto changes = [&](const std::string& first, const std::string& second, const std::string& third) {
    folder.write("third.txt", "1");
    folder.write(second, third);
    const std::filesystem::path top = folder.write("top.toml", first);
    const std::string one = input::ContentHash().add_input_file(top).hex();
    folder.write("third.txt", "2");
    return one != input::ContentHash().add_input_file(top).hex();
  };
  EXPECT_TRUE(changes("file = \"sub.toml\"", "sub.toml", "file = 'third.txt'"));
  EXPECT_TRUE(changes("file = \"deck.inp\"", "deck.inp", "*NODE\n*Include, Input=third.txt\n"));
  EXPECT_TRUE(changes("file = \"deck.bdf\"", "deck.bdf", "BEGIN BULK\nINCLUDE 'third.txt'\n"));
  EXPECT_TRUE(changes("file = \"sub.toml\"", "sub.toml", "a = 'sub.toml'\nb = 'top.toml'\nc = 'third.txt'"));
  EXPECT_FALSE(changes("file = \"sub.toml\"", "sub.toml", "file = 'fourth.txt'"));
  EXPECT_NE(input::ContentHash().add("ab").add("c").hex(), input::ContentHash().add("a").add("bc").hex());
}

class StudyCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.write("oscillator.toml", kOscillator);
    folder_.write("study.toml", kStudy);
  }
  Outcome study(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"study", folder_ / "study.toml", "-o", folder_ / "out"});
    return test::run("flexura", more);
  }
  nlohmann::json json() const { return nlohmann::json::parse(read_text(folder_ / "out.json")); }

  Folder folder_;
};

TEST_F(StudyCommand, MeasuresErrorsAgainstAReferenceThatIsExactHere) {
  const Outcome outcome = study();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto out = json();
  const auto& choices = out.at("choices");
  ASSERT_EQ(choices.size(), 3u);
  // The error falls with the tolerance, is far above the reference's uncertainty, and costs steps.
  double last = 1.0;
  long steps = 0;
  for (const auto& choice : choices) {
    EXPECT_EQ(choice.at("wall").size(), 2u);
    EXPECT_GT(choice.at("peak_memory"), 1e6);
    EXPECT_LT(choice.at("error"), last);
    EXPECT_GT(choice.at("steps"), steps);
    last = choice.at("error");
    steps = choice.at("steps");
  }
  EXPECT_LT(out.at("uncertainty"), 0.1 * last);
  EXPECT_EQ(choices.back().at("error_to_finest"), 0.0);
  EXPECT_THAT(outcome.out, HasSubstr("cheapest within 1 %: tolerance 1e-"));
  EXPECT_THAT(outcome.out,
              HasSubstr("within 1e-12 %: none of these choices; the reference itself is only known"));
  // The CSV has the same figures, one line for each choice below the heading.
  const std::string csv = read_text(folder_ / "out.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_THAT(read_text(folder_ / "out.svg"), HasSubstr("</svg>"));
}

TEST_F(StudyCommand, ComparesWhatTheProgramChoosesWithTheCheapestRung) {
  folder_.write("study.toml",
                replaced(replaced(kStudy, "[want]", "[want]\nchosen = true"), ", \"1e-12 %\"", ""));
  const Outcome outcome = study();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  // A tolerance of a thousandth of the accuracy, over two periods of an oscillator.
  EXPECT_THAT(outcome.out, HasSubstr("chosen by the program for 1 %: "));
  EXPECT_THAT(outcome.out, HasSubstr(": met, at "));
  const auto choices = json().at("choices");
  ASSERT_EQ(choices.size(), 4u);
  EXPECT_DOUBLE_EQ(choices[0].at("wanted"), 0.01);
  EXPECT_FALSE(choices[0].at("on_front"));
  EXPECT_LT(choices[0].at("error"), 0.01);
  EXPECT_THAT(read_text(folder_ / "out.md"), HasSubstr("| wanted | chosen: error | met |"));
}

TEST_F(StudyCommand, GoesOnWhereItWasInterruptedAndFollowsTheContent) {
  // Two shares by themselves, as two jobs of an array; the third call finds all runs and gathers.
  EXPECT_EQ(study({"--share", "1/2"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "out.json"));
  EXPECT_EQ(study({"--share", "2/2"}).exit_code, 0);
  const auto stamp = [&] {
    std::map<std::string, fs::file_time_type> times;
    for (const auto& entry : fs::directory_iterator(folder_ / "study.cache"))
      times[entry.path().filename()] = entry.last_write_time();
    return times;
  };
  const auto before = stamp();
  ASSERT_EQ(study().exit_code, 0);
  EXPECT_EQ(stamp(), before);
  const auto first = json();
  ASSERT_EQ(study({"-j", "2"}).exit_code, 0);
  EXPECT_EQ(json(), first);
  // Another mass is another mechanism.
  folder_.write("oscillator.toml", replaced(kOscillator, "2 kg", "3 kg"));
  ASSERT_EQ(study().exit_code, 0);
  EXPECT_EQ(stamp().size(), 2 * before.size());
  EXPECT_NE(json(), first);
}

TEST_F(StudyCommand, WhatIsDamagedInTheCacheIsMadeAgain) {
  ASSERT_EQ(study().exit_code, 0);
  const auto errors = [&] {
    std::vector<double> all;
    const auto out = json();
    for (const auto& choice : out.at("choices")) all.push_back(choice.at("error"));
    return all;
  };
  const auto first = errors();
  const auto file = [&](const char* ending, std::size_t n) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_ / "study.cache"))
      if (entry.path().extension() == ending) files.push_back(entry.path());
    std::ranges::sort(files);
    return files.at(n % files.size());
  };
  const auto damage = [&](const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
    const Outcome again = study();
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_THAT(again.err,
                HasSubstr("note: " + path.string() + " is not what was written there: it is made again"));
    EXPECT_EQ(errors(), first);
  };
  const std::string results = read_text(file(".h5", 0));
  std::string changed = results;  // a number of the rows: HDF5 still reads it
  changed[changed.size() / 2] = static_cast<char>(changed[changed.size() / 2] ^ 1);
  damage(file(".h5", 0), changed);
  damage(file(".h5", 1), results.substr(0, results.size() / 2));
  damage(file(".h5", 2), "");
  const std::string entry = read_text(file(".json", 0));
  damage(file(".json", 0), replaced(entry, "\"wall\": [", "\"wall\": [0.5, "));
  damage(file(".json", 1), entry.substr(0, 20));
  damage(file(".json", 2), "[[[[");
  // Nothing is left to be made again.
  EXPECT_THAT(study().err, Not(HasSubstr("note: ")));
}

// As where the stress of a body is asked for that one rung has rigid.
TEST_F(StudyCommand, GoesOnWhereARungRefusesToRun) {
  const std::string rungs = R"toml(
[axis.spring.choice.loose]
set = ["force.spring.joint=none"]
[axis.spring.choice.there]
set = []
[quantity.position])toml";
  folder_.write("study.toml", replaced(kStudy, "[quantity.position]", rungs));
  const Outcome outcome = study();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("note: tolerance 1e-3, loose: "));
  const auto choices = json().at("choices");
  ASSERT_EQ(choices.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) {
    const bool refuses = k % 2 == 0;
    EXPECT_EQ(choices[k].at("complete"), !refuses) << choices[k];
    if (refuses)
      EXPECT_THAT(choices[k].at("failure").get<std::string>(), HasSubstr("there is no joint \"none\""));
  }
  // Where it is the reference there is nothing to measure against.
  folder_.write("study.toml",
                replaced(kStudy, "[want]",
                         "[reference]\nset = [\"force.spring.joint=none\"]\n"
                         "[reference.check.tolerance]\nset = [\"solver.tolerance=1e-8\"]\n[want]"));
  const Outcome refused = study();
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("choice \"reference\": "));
}

TEST_F(StudyCommand, RefusesBeforeAnythingRuns) {
  const auto refused = [&](const std::string& text, const std::vector<std::string>& more = {}) {
    folder_.write("study.toml", text);
    const Outcome outcome = study(more);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(refused(replaced(kStudy, "solver.tolerance", "solver.tolerances")),
              HasSubstr("choice \"tolerances 1e-3\""));
  EXPECT_THAT(refused(replaced(kStudy, "repeats", "run = \"fast\"\nrepeats")), HasSubstr("has no such run"));
  EXPECT_THAT(refused(kStudy, {"--share", "3/2"}), HasSubstr("--share 3/2: give I/N with 1 <= I <= N"));
  EXPECT_THAT(refused(kStudy, {"--jobs", "0"}), HasSubstr("--jobs is 0"));
  EXPECT_THAT(refused(replaced(kStudy, "slide.position", "slide.positions")), HasSubstr("slide.position"));
}

}  // namespace
}  // namespace flexura::study
