// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// Loops of bodies that deform close by turning joints, whatever the initial angles: bodies are strained only for what
/// no motion of rigid ones closes, by the least energy, and that is said. Parts are steel beams of 20 x 10 mm of
/// 100 to 400 mm; loops/ holds mechanisms of the family, user/ those by which it was found.
namespace flexura {
namespace {

namespace fs = std::filesystem;
using test::Outcome;
using test::run;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kDegree = M_PI / 180.0;
// Steel, 20 x 10 mm.
constexpr double E = 210e9, nu = 0.3, A = 20e-3 * 10e-3, I_wide = 10e-3 * 20e-3 * 20e-3 * 20e-3 / 12.0;

struct Start {
  Outcome outcome;
  std::map<std::string, std::map<std::string, double>> of_run;  // quantities at t = 0
  double operator()(const std::string& quantity, const std::string& run = "run") const {
    return of_run.at(run).at(quantity);
  }
};

class Loops : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::Folder;
    const fs::path found = fs::path(FLEXURA_SOURCE_DIR) / "tests/found";
    for (const auto& entry : fs::directory_iterator(found / "loops")) fs::copy(entry.path(), folder_->path());
    for (const char* name : {"tri.toml", "bar.toml"}) fs::copy(found / "user" / name, folder_->path());
    for (const std::string part : {"b10", "b20", "b25", "b40", "bar"}) {
      const Outcome made =
          run("flexura-reduce", {*folder_ / (part + ".toml"), "-o", *folder_ / (part + ".se.h5"), "-q"});
      ASSERT_EQ(made.exit_code, 0) << made.err;
    }
  }
  static void TearDownTestSuite() { delete folder_; }

  static void write(const std::string& name, const std::string& text) { folder_->write(name, text); }
  static Start start_of(const std::string& name, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"simulate",
                                   *folder_ / (name + ".toml"),
                                   "-o",
                                   *folder_ / "rows.h5",
                                   "--no-estimate",
                                   "--end-time",
                                   "1e-6",
                                   "--set",
                                   "solver.output_step=1e-6"};
    words.insert(words.end(), more.begin(), more.end());
    Start start{run("flexura", words), {}};
    if (start.outcome.exit_code != 0) return start;
    for (const results::Run& one : results::read(*folder_ / "rows.h5").runs)
      for (std::size_t k = 0; k < one.quantities.size(); ++k)
        start.of_run[one.name][one.quantities[k].name] = one.values(0, static_cast<Eigen::Index>(k));
    return start;
  }

  static const test::Folder& folder() { return *folder_; }

 private:
  static inline test::Folder* folder_ = nullptr;
};

// Bars of 250 mm on bearings 260 mm apart, which their apex joins: cos = 130 / 250.  Bearing A carries the weight of
// one bar, across the plane: from the start where the bars have settled under it.
TEST_F(Loops, TwoBarsTurnAndCarryTheirWeight) {
  const Start s = start_of("tri");
  ASSERT_EQ(s.outcome.exit_code, 0) << s.outcome.err;
  for (const char* kind : {"rigid", "flexible"}) {
    EXPECT_NEAR(s("A.angle", kind), std::acos(0.52), 1e-13);
    EXPECT_NEAR(s("B.angle", kind), M_PI - std::acos(0.52), 1e-13);
    EXPECT_NEAR(s("energy.strain", kind), 0.0, 1e-15);
  }
  const Start settled = start_of("tri", {"--set", "solver.initial_deformation=quasi_static"});
  ASSERT_EQ(settled.outcome.exit_code, 0) << settled.outcome.err;
  // 7850 kg/m^3 of steel.
  for (const char* kind : {"rigid", "flexible"})
    EXPECT_NEAR(settled("A.force", kind), 7850.0 * A * 0.25 * 9.81, 1e-5) << kind;
  EXPECT_THAT(s.outcome.err,
              AllOf(HasSubstr("do not close the loops and were moved: \"A.angle\" from 60 to 58.66"),
                    Not(HasSubstr("warning"))));
}

// An angle of 60 degrees that is off in its eighth digit: "moved from 60 to 60 deg" is no news.
TEST_F(Loops, MovesThatRoundToNothingAreNotTold) {
  write("square.toml", R"toml(gravity = [0, 0, 0]
[ground.marker.a]
axis = [0, 1, 0]
[ground.marker.d]
position = [0.4, 0, 0]
axis = [0, 1, 0]
[body.crank]
mass = 1
inertia = [0.01, 0.01, 0.01]
[body.crank.marker.a]
axis = [0, 1, 0]
[body.crank.marker.b]
position = [0.2, 0, 0]
axis = [0, 1, 0]
[body.rocker]
mass = 1
inertia = [0.01, 0.01, 0.01]
[body.rocker.marker.d]
axis = [0, 1, 0]
[body.rocker.marker.c]
position = [0.2, 0, 0]
axis = [0, 1, 0]
[joint.A]
type = "revolute"
from = "ground.a"
to = "crank.a"
angle = "60 deg"
[joint.D]
type = "revolute"
from = "ground.d"
to = "rocker.d"
angle = "60.000004 deg"
[constraint.link]
type = "distance"
from = "crank.b"
to = "rocker.c"
length = 0.4
)toml");
  const Start near = start_of("square");
  EXPECT_EQ(near.outcome.exit_code, 0) << near.outcome.err;
  EXPECT_THAT(near.outcome.err, Not(HasSubstr("moved")));
  const Start off = start_of("square", {"--set", "joint.D.angle=60.01 deg"});
  EXPECT_THAT(off.outcome.err, HasSubstr("were moved"));
}

// Whatever law the bars deform by.
TEST_F(Loops, OneWayStaticStiffenedAncfAndSegmentedBarsTurnToo) {
  for (const std::string fidelity : {"ked", "static", "modal"}) {
    const Start s = start_of("tri", {"--run", "flexible", "--set", "body.left.fidelity=" + fidelity, "--set",
                                     "body.right.fidelity=" + fidelity});
    ASSERT_EQ(s.outcome.exit_code, 0) << fidelity << s.outcome.err;
    EXPECT_NEAR(s("A.angle", "flexible"), std::acos(0.52), 1e-13) << fidelity;
    EXPECT_NEAR(s("energy.strain", "flexible"), 0.0, 1e-15) << fidelity;
  }
  const Start stiffened = start_of("two_loops", {"--set", "body.b2.fidelity=modal-stiffened", "--set",
                                                 "body.b4.fidelity=modal-stiffened"});
  ASSERT_EQ(stiffened.outcome.exit_code, 0) << stiffened.outcome.err;
  EXPECT_NEAR(stiffened("energy.strain"), 0.0, 1e-15);
  for (const std::string law : {"tri_ancf", "tri_segments"}) {
    const Start s = start_of(law);
    ASSERT_EQ(s.outcome.exit_code, 0) << law << s.outcome.err;
    EXPECT_NEAR(s("A.angle"), std::acos(0.52), 1e-12) << law;
    // Joints between segments hold round-off of 1e-16 m and rad: 1e8 N/m make 1e-24 J of it.
    EXPECT_NEAR(s("energy.strain") + s("energy.potential"), 0.0, 1e-15) << law;
  }
}

// Slider-crank, inverted slider, two loops, a spatial loop: every coordinate given some degrees or millimetres off.
TEST_F(Loops, GuessesThatAreOffStrainNothing) {
  for (const std::string name : {"slider_crank", "inverted_slider", "two_loops", "spatial"}) {
    const Start s = start_of(name);
    ASSERT_EQ(s.outcome.exit_code, 0) << name << s.outcome.err;
    EXPECT_NEAR(s("energy.strain"), 0.0, 1e-15) << name;
    EXPECT_THAT(s.outcome.err, AllOf(HasSubstr("were moved"), Not(HasSubstr("warning")))) << name;
  }
  // The crank (100 mm) and the rod (250 mm) lead to the slider on the x axis.
  const Start s = start_of("slider_crank");
  const double shaft = s("shaft.angle"), rod = shaft + s("pin.angle");
  EXPECT_NEAR(0.1 * std::sin(shaft) + 0.25 * std::sin(rod), 0.0, 1e-14);
  EXPECT_NEAR(0.1 * std::cos(shaft) + 0.25 * std::cos(rod), s("guide.position"), 1e-14);
  // None of the three jumped to another branch: guesses were within 10 degrees and 20 mm.
  EXPECT_NEAR(shaft, 40.0 * kDegree, 10.0 * kDegree);
  EXPECT_NEAR(s("guide.position"), 0.3, 0.02);
}

// A five-bar has two freedoms and both are given; a four-bar one, beside a spring: free joints close the loop, and
// given angles stay to the last bit.
TEST_F(Loops, GivenAnglesStayWhereFreeJointsCanClose) {
  const Start five = start_of("five_bar");
  ASSERT_EQ(five.outcome.exit_code, 0) << five.outcome.err;
  EXPECT_EQ(five("A.angle"), 100.0 * kDegree);
  EXPECT_EQ(five("E.angle"), 80.0 * kDegree);
  EXPECT_NEAR(five("energy.strain"), 0.0, 1e-15);
  const Start four = start_of("four_bar_spring");
  ASSERT_EQ(four.outcome.exit_code, 0) << four.outcome.err;
  EXPECT_EQ(four("A.angle"), 75.0 * kDegree);
  EXPECT_NEAR(four("energy.strain"), 0.0, 1e-15);
}

// A bar of 250 mm between bearings 250.5 mm apart: U = E A d^2 / 2 L.
TEST_F(Loops, ABarTooShortForItsBearingsIsStretchedAndSaysSo) {
  const Start s = start_of("bar_too_long");
  ASSERT_EQ(s.outcome.exit_code, 0) << s.outcome.err;
  const double k = E * A / 0.25, d = 0.5e-3;
  EXPECT_NEAR(s("energy.strain"), 0.5 * k * d * d, 1e-9 * k * d * d);
  EXPECT_NEAR(s("A.force"), k * d, 1e-9 * k * d);
  EXPECT_THAT(s.outcome.err, AllOf(HasSubstr("warning: "), HasSubstr("by 0.5 mm"),
                                   HasSubstr("strain energy of 21 J"), HasSubstr("8.4e+04 N in \"B.")));
}

// A cantilever whose end a line holds 1 mm aside: of all ways to bend there, the one of least energy is that under a
// force at its end, k = 1 / (L^3 / 3 EI + L / kappa G A), kappa = 5/6 within 2 %.
TEST_F(Loops, WhatOnlyDeformationClosesTakesTheLeastEnergy) {
  const Start s = start_of("cantilever_held_off");
  ASSERT_EQ(s.outcome.exit_code, 0) << s.outcome.err;
  const double L = 0.25, G = E / (2.0 * (1.0 + nu));
  const double k = 1.0 / (L * L * L / (3.0 * E * I_wide) + L / (5.0 / 6.0 * G * A));
  // Shear makes 0.5 % of the compliance.
  EXPECT_NEAR(s("energy.strain"), 0.5 * k * 1e-6, 2e-4 * 0.5 * k * 1e-6);
  EXPECT_THAT(s.outcome.err, AllOf(HasSubstr("by 1 mm"), HasSubstr("with the least strain energy")));
}

// A misfit of 0.1 um beside parts that weigh: said, but the loads ask for more.
TEST_F(Loops, AMisfitFinerThanPartsAreMadeIsNoWarning) {
  const std::string text =
      test::replaced(test::read_text(folder() / "bar_too_long.toml"), "0.2505", "0.2500001");
  folder().write("fine_misfit.toml", text);
  const Start s = start_of("fine_misfit");
  ASSERT_EQ(s.outcome.exit_code, 0) << s.outcome.err;
  const double k = E * A / 0.25, d = 1e-7;
  EXPECT_NEAR(s("energy.strain"), 0.5 * k * d * d, 1e-6 * k * d * d);
  EXPECT_THAT(s.outcome.err, AllOf(HasSubstr("note: "), HasSubstr("no motion of the joints closes the loops"),
                                   Not(HasSubstr("warning"))));
}

// The apex of two bars on bearings 600 mm apart stays open by 100 mm: units, names, and a page that shows it.
TEST_F(Loops, WhatCannotCloseIsNamedAndShown) {
  // Two bars of 250 mm over 600 mm: 100 mm are missing at the least.
  std::string text = test::replaced(test::read_text(folder() / "tri.toml"), "260 mm", "600 mm");
  folder().write("too_far.toml", text);
  for (const std::string command : {"assemble", "statics", "simulate"}) {
    const test::Folder beside;
    std::vector<std::string> words{command, folder() / "too_far.toml", "--run", "rigid"};
    if (command == "simulate") words.insert(words.end(), {"-o", beside / "rows.h5"});
    const Outcome outcome = run("flexura", words);
    EXPECT_EQ(outcome.exit_code, 2) << command;
    EXPECT_THAT(outcome.err,
                AllOf(HasSubstr("cannot be assembled"), HasSubstr("\"C\" (from \"left.b\" to \"right.b\")"),
                      HasSubstr("by 100 mm"), HasSubstr(".open.html")))
        << command;
    const fs::path page = "too_far.open.html";
    ASSERT_TRUE(fs::exists(page)) << command;
    const std::string html = test::read_text(page);
    EXPECT_THAT(html, AllOf(HasSubstr("open: C"), HasSubstr("#d62728"), HasSubstr("does not assemble")));
    fs::remove(page);
    EXPECT_FALSE(fs::exists(beside / "rows.h5"));
  }
}

// A link of 0.1 mm between places that stay 100 mm apart: its row is (d^2 - L^2) / 2 L, 50 m.
TEST_F(Loops, ALinkThatStaysOpenIsSaidInMillimetres) {
  std::string text = test::replaced(test::read_text(folder() / "tri.toml"), "260 mm", "600 mm");
  const std::size_t at = text.find("[joint.C]");
  ASSERT_NE(at, std::string::npos);
  text = test::replaced(text, text.substr(at, text.find("[solver]") - at),
                        "[constraint.C]\ntype = \"distance\"\nfrom = \"left.b\"\nto = \"right.b\"\n"
                        "length = \"0.1 mm\"\n");
  const Outcome outcome =
      run("flexura", {"assemble", folder().write("short_link.toml", text).string(), "--run", "rigid"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("by 99.9 mm"));
  fs::remove("short_link.open.html");
}

}  // namespace
}  // namespace flexura
