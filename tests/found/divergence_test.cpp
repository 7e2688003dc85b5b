// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// What grows without bound ends the run with exit 1 and keeps the rows; what leaves the range of its linear
/// deformation is named with time, place and body, between interfaces too; long or fast motion is neither.
namespace flexura {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using test::Outcome;
using test::run;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

const fs::path kFound = fs::path(FLEXURA_SOURCE_DIR) / "tests/found";

Outcome simulate(const Folder& folder, const std::string& name, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"simulate", folder / name, "-o", folder / "rows.h5", "--no-estimate"};
  words.insert(words.end(), more.begin(), more.end());
  return run("flexura", words);
}

void reduce(const Folder& folder, const fs::path& part) {
  fs::copy(part, folder.path(), fs::copy_options::skip_existing);
  const Outcome made =
      run("flexura-reduce", {folder / part.filename(), "-o", folder / part.stem().concat(".se.h5"), "-q"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
}

// Rows before the trouble are there, and the file says why there are no more.
void expect_kept(const Folder& folder, const std::string& reason) {
  const results::Results kept = results::read(folder / "rows.h5");
  ASSERT_EQ(kept.runs.size(), 1u);
  EXPECT_FALSE(kept.runs[0].complete);
  EXPECT_THAT(kept.runs[0].stopped_because, HasSubstr(reason));
  EXPECT_GT(kept.runs[0].time.size(), 10);
}

// The centre of mass stays where it is: no speed of a place tells, and the energy leaves the numbers.
TEST(Divergence, ADriveThatLeavesTheNumbersEndsTheRun) {
  const Folder folder;
  folder.write("spin.toml",
               "[body.a]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j]\ntype = \"revolute\"\nfrom = "
               "\"ground\"\nto = \"a\"\ndrive_speed = \"exp(1e6*t)\"\n[solver]\nend_time = "
               "0.0004\noutput_step = 1e-6\n");
  const Outcome outcome = simulate(folder, "spin.toml");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("grows without bound"));
  expect_kept(folder, "grows without bound");
}

// Kane's beam spun past its first clamped frequency, one-way: 7e22 m after 19 s.
TEST(Divergence, ABeamSpunPastItsRangeEndsTheRun) {
  const Folder folder;
  reduce(folder, kFound / "flex/ked/kane.toml");
  fs::copy(kFound / "flex/ked/kspin.toml", folder.path());
  for (const std::string fidelity : {"ked"}) {
    const Outcome outcome = simulate(folder, "kspin.toml",
                                     {"--set", "body.b.fidelity=" + fidelity, "--set", "body.b.modes=4",
                                      "--end-time", "19", "--set", "solver.output_step=0.05"});
    EXPECT_EQ(outcome.exit_code, 1) << fidelity << outcome.out << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("body \"b\""), HasSubstr("times its own size"),
                                   HasSubstr("t = "), HasSubstr("without bound")))
        << fidelity;
    expect_kept(folder, "times its own size");
  }
}

TEST(LinearRange, AGuidedBeamWhoseEndsStayParallelIsWarnedOf) {
  const Folder folder;
  reduce(folder, kFound / "trade/sturdy.toml");
  fs::copy(kFound / "trade/scene_linear_range.toml", folder.path());
  const Outcome outcome = simulate(folder, "scene_linear_range.toml");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("body \"b\" leaves the linear range"), HasSubstr("is displaced by 0.159"),
                    HasSubstr("against \"a\""), HasSubstr("t = 0.")));
}

// Clamped at both ends, 400 x 20 x 10 mm, under W = rho A g L it sags by w = W / L x^2 (L - x)^2 / 24 E I where there is
// no interface: 2e5 m/s^2 make 60 mm in the middle and most of the distance x to an end, 0.35, at the place of the
// surface next to x = L / 3, or as far from the other end; 5e4 make a quarter.
TEST(LinearRange, TheMiddleOfAClampedBeamIsLookedAt) {
  const Folder folder;
  reduce(folder, kFound / "loops/b40.toml");
  folder.write("clamped.toml", R"(gravity = [0, 0, -2e5]
[ground.marker.A]
[ground.marker.B]
position = [0.4, 0, 0]
[body.b]
superelement = "b40.se.h5"
[joint.A]
type = "fixed"
from = "ground.A"
to = "b.a"
[joint.B]
type = "fixed"
from = "ground.B"
to = "b.b"
)");
  const Outcome outcome = run("flexura", {"statics", folder / "clamped.toml"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  // A warning as in simulate, not a note.
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("warning: run: body \"b\" leaves the linear range"),
                    AnyOf(HasSubstr("its surface at (0.15, "), HasSubstr("its surface at (0.25, ")),
                    HasSubstr("is displaced by 0.053"), HasSubstr("against \"")));
  const Outcome less = run("flexura", {"statics", folder / "clamped.toml", "--set", "gravity=[0,0,-5e4]"});
  EXPECT_EQ(less.exit_code, 0) << less.err;
  EXPECT_THAT(less.out + less.err, Not(HasSubstr("linear range")));
}

// The same beam, 10 mm thick, under q per length: w = W (16 x^2 (L - x)^2 / L^4), W = q L^4 / 384 E I.  Its ends should
// come closer by 2.4381 W^2 / L, and held apart it is stiffer by 0.696 (W / h)^2: N u / U with N = E A u / L and
// U = 1/2 E I int w''^2.  1.6e4 m/s^2 make W = 4.785 mm, u = 0.1396 mm, 15.9 %; stations along the surface see 1 % less.
TEST(LinearRange, EndsHeldApartPullWhatBends) {
  const Folder folder;
  reduce(folder, kFound / "loops/b40.toml");
  const auto said = [&](const std::string& joint, const std::string& more) {
    folder.write("held.toml", R"(gravity = [0, 0, -1.6e4]
[ground.marker.A]
[ground.marker.B]
position = [0.4, 0, 0]
axis = [1, 0, 0]
[ground.marker.O]
position = [-1, 0, 0]
[body.b]
superelement = "b40.se.h5"
[body.b.marker.tip]
on = "b"
axis = [1, 0, 0]
[body.w]
mass = 1
inertia = [1, 1, 1]
position = [0.4, 0, 0]
[body.w.marker.o]
axis = [1, 0, 0]
[joint.A]
type = "fixed"
from = "ground.A"
to = "b.a"
[joint.B]
from = "ground.B"
to = "w.o"
type = ")" + joint + R"("
[joint.C]
type = "fixed"
from = "w.o"
to = "b.tip"
)" + more);
    const Outcome outcome = run("flexura", {"statics", folder / "held.toml"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.out + outcome.err;
  };
  EXPECT_THAT(said("fixed", ""),
              AllOf(HasSubstr("body \"b\" is held where its bending"), HasSubstr("by 0.000138 m"),
                    HasSubstr("a tension of 1.45e+04 N"), HasSubstr("about 16 % more stiffness")));
  EXPECT_THAT(said("prismatic", ""), Not(HasSubstr("is held where")));
  // Held by a spring as stiff as the beam is along itself, E A / L = 1.05e8 N/m: half of it.
  EXPECT_THAT(said("prismatic", R"([force.s]
type = "spring_damper"
from = "ground.O"
to = "w.o"
stiffness = 1.05e8
free_length = 1.4
)"),
              AllOf(HasSubstr("a tension of 7.2"), HasSubstr("about 7.8 % more stiffness")));
}

constexpr const char* kSlider = R"(gravity = [0, 0, 0]
[ground.marker.o]
[body.b]
mass = 1
inertia = [1, 1, 1]
[body.b.marker.o]
[joint.j]
type = "prismatic"
from = "ground.o"
to = "b.o"
position = 1e-3
[force.f]
type = "joint_force"
joint = "j"
value = "FORCE"
[solver]
end_time = END
output_step = STEP
)";

Outcome slide(const Folder& folder, const std::string& force, const std::string& end,
              const std::string& step) {
  std::string text = test::replaced(kSlider, "FORCE", force);
  text = test::replaced(test::replaced(text, "END", end), "STEP", step);
  folder.write("slider.toml", text);
  return simulate(folder, "slider.toml");
}

TEST(Divergence, AnUnstableControlEndsTheRun) {
  const Folder folder;
  // x = 1e-3 cosh(2 t); and a damper of negative sign on an oscillator, exp(0.5 t) sin(10 t).
  for (const std::string force : {"4*j.position", "-100*j.position + j.speed"}) {
    const Outcome outcome = slide(folder, force, "60", "0.05");
    EXPECT_EQ(outcome.exit_code, 1) << outcome.out;
    EXPECT_THAT(outcome.err,
                AllOf(HasSubstr("grows without bound"), HasSubstr("tenfold"), HasSubstr("t = ")));
    expect_kept(folder, "grows without bound");
  }
}

// It grows by 80 within each period, faster than rows of one period's step tell, and turns faster than steps can follow.
TEST(Divergence, ASampledLoopTooStiffForItsPeriodEndsAtOnce) {
  const Folder folder;
  fs::copy(kFound / "integrators/unstable_sampled.toml", folder.path());
  for (const char* const step : {"1 ms", "10 ms"}) {
    const Outcome outcome =
        simulate(folder, "unstable_sampled.toml", {"--set", std::string("solver.output_step=") + step});
    EXPECT_EQ(outcome.exit_code, 1) << outcome.out;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("grows without bound"), HasSubstr("at t = 0.00"),
                                   HasSubstr("\"hinge.speed\" goes farthest")));
  }
}

TEST(Divergence, LongAndFastMotionIsNone) {
  const Folder folder;
  // 10 m/s^2 for 2e4 s: 2e9 m at 2e5 m/s; a force that grows with time for as long; what falls over and swings on.
  EXPECT_EQ(slide(folder, "10", "2e4", "50").exit_code, 0);
  EXPECT_EQ(slide(folder, "1e-2*t", "2e4", "50").exit_code, 0);
  EXPECT_EQ(slide(folder, "j.position - 0.01*j.position^3", "60", "0.05").exit_code, 0);
}

}  // namespace
}  // namespace flexura
