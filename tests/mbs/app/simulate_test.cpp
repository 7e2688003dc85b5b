// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/mbs/app/flexura_fixture.hpp"

/// `flexura simulate`: what it writes, what it says, how it ends.
namespace flexura {
namespace {

using testing::Flexura;
using ::testing::HasSubstr;
using testing::Outcome;
using testing::run_program;

constexpr const char* kBlockOnGuide = R"toml([body.block]
mass = 1
[joint.slide]
type = "prismatic"
from = "ground"
to = "block"
)toml";

TEST_F(Flexura, SimulateWritesAPage) {
  const std::string run = "simulate " FLEXURA_SOURCE_DIR
                          "/cases/macpherson/macpherson.toml --run bump --end-time 0.02 -o " +
                          (folder_ / "bump.h5").string();
  const std::string page = (folder_ / "bump.html").string();
  const Outcome outcome = flexura(run + " --html " + page);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("page    " + page + " ("));
  EXPECT_GT(std::filesystem::file_size(page), 10'000u);
  // One file cannot be both.
  const Outcome twice = flexura(run + " --html " + (folder_ / "bump.h5").string());
  EXPECT_EQ(twice.code, 2);
  EXPECT_THAT(twice.err, HasSubstr("bump.h5"));
}

// A force with a pole half way, taken by the guide alone, so that no step is cut back before the row at the
// pole: the run up to there is kept, readable and named.
TEST_F(Flexura, SimulateKeepsWhatCameBeforeAValueThatIsNotFinite) {
  const auto mechanism = folder_ / "pole.toml", results = folder_ / "pole.h5";
  std::ofstream(mechanism) << kBlockOnGuide << R"toml([force.push]
type = "force"
marker = "block"
x = "1/(t - 0.5)^2"
[solver]
end_time = 1
output_step = 0.01
)toml";
  Outcome outcome = flexura("simulate " + mechanism.string() + " -o " + results.string());
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(
      outcome.err,
      HasSubstr("push.x = \"1/(t - 0.5)^2\" is inf at t = 0.5 s, a finite number is wanted; correct the "
                "formula or what it reads; what was computed until then is in " +
                results.string()));
  outcome = flexura("view --summary " + results.string());
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("0.49\n"));
}

// A bead on a turning rod, r = 0.4 m cosh(2 t), passes its end at 2.1 m at acosh(5.25) / 2 = 1.17109 s.
TEST_F(Flexura, SimulateEndsWhereAMarkerPassesTheEndOfItsPath) {
  const auto mechanism = folder_ / "rod.toml", results = folder_ / "rod.h5";
  std::ofstream(mechanism) << R"toml(gravity = [0, 0, 0]
[body.rod]
mass = 1
inertia = [1, 1, 1]
[body.rod.marker.a]
position = [0.1, 0, 0]
[body.rod.marker.b]
position = [2.1, 0, 0]
[joint.spin]
type = "revolute"
from = "ground"
to = "rod"
drive = "2*t"
[body.bead]
mass = 0.7
inertia = [0.1, 0.2, 0.3]
position = [0.4, 0, 0]
velocity = [0, 0.8, 0]
[constraint.slide]
type = "point_on_path"
path = ["rod.a", "rod.b"]
to = "bead"
[solver]
end_time = 2
output_step = 0.001
)toml";
  const Outcome outcome = flexura("simulate " + mechanism.string() + " -o " + results.string());
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err,
              HasSubstr("constraint \"slide\": its marker passed the end of the path, which goes from "
                        "0 to 2 m, at about t = 1.1710"));
  EXPECT_EQ(flexura("simulate " + mechanism.string() +
                    " --set constraint.slide.ends=straight --set solver.end_time=1.2 -o " + results.string())
                .code,
            0);
}

// A soft cable of 1 m and two elements, clamped at its root; `keys` are of its beam.
std::string clamped_cable(const std::string& fidelity, const std::string& keys = "") {
  return "[body.cable]\nfidelity = \"" + fidelity + "\"\n[body.cable.beam]\n" + keys + R"toml(
to = [1, 0, 0]
elements = 2
young = "1 MPa"
density = 1000
diameter = "10 mm"
[joint.clamp]
type = "fixed"
from = "ground"
to = "cable.root"
)toml";
}

// A body without superelement: what it leaves out is told in words.
TEST_F(Flexura, SimulateEstimatesTheErrorBesideAnAncfBeam) {
  const auto mechanism = folder_ / "cable.toml";
  std::ofstream(mechanism) << clamped_cable("ancf") + R"toml([solver]
end_time = "1 ms"
)toml";
  const Outcome outcome =
      flexura("simulate " + mechanism.string() + " -o " + (folder_ / "cable.h5").string());
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("elements of cable: --check-elements tells"));
}

// The force at the tip of a planar beam, which is one body with its frame at the root, is drawn on the last element, which bends away.
TEST_F(Flexura, PageOfAPlanarBeamHasItsForcesOnTheElements) {
  const auto mechanism = folder_ / "planar.toml";
  std::ofstream(mechanism) << clamped_cable("beam", "planar = true") + R"toml([force.pull]
type = "force"
marker = "cable.tip"
y = 1e-6
[solver]
end_time = "1 ms"
)toml";
  const auto page = folder_ / "planar.html";
  const Outcome outcome = flexura("simulate " + mechanism.string() + " -o " +
                                  (folder_ / "planar.h5").string() + " --html " + page.string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::ifstream in(page);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  EXPECT_THAT(text, HasSubstr(R"("body_2":"cable.element_2")"));
}

// Ctrl-C: the run ends after the step under way, with code 1 and its time; what it has is readable.
TEST_F(Flexura, SimulateEndsCleanlyWhenInterrupted) {
  const auto mechanism = folder_ / "long.toml", results = folder_ / "long.h5", script = folder_ / "run.sh";
  std::ofstream(mechanism) << kBlockOnGuide << R"toml([force.spring]
type = "joint_spring_damper"
joint = "slide"
stiffness = 1000
[solver]
end_time = 1e6
output_step = 0.1
)toml";
  // Rows are there before the signal comes.
  std::ofstream(script) << FLEXURA_BIN_DIR "/flexura simulate " << mechanism.string() << " -o "
                        << results.string() << " &\nchild=$!\nsleep 1.5\nkill -INT $child\nwait $child\n";
  const auto begin = std::chrono::steady_clock::now();
  const Outcome stopped = run_program("bash " + script.string());
  EXPECT_EQ(stopped.code, 1) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("interrupted at t = "));
  EXPECT_THAT(stopped.err, HasSubstr("what was computed until then is in " + results.string()));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
  const Outcome view = flexura("view --summary " + results.string());
  EXPECT_EQ(view.code, 0) << view.err;
  EXPECT_THAT(view.err + view.out, HasSubstr("interrupted at t = "));
}

}  // namespace
}  // namespace flexura
