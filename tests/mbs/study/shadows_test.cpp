// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/shadows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/study/clamped_bar.hpp"
#include "tests/mbs/study/rows_of_run.hpp"
#include "tests/mbs/superelement/box_beam.hpp"

namespace flexura::study {
namespace {

using test::Folder;

class ShadowsOfABar : public ::testing::Test {
 protected:
  void SetUp() override {
    superelement::write(folder_ / "beam.se.h5", superelement::testing::make_box_beam());
    file_ = folder_.write("bar.toml", bars::kClamped);
  }

  struct Run {
    Eigen::MatrixXd values;  // rows x outputs
    TruncationEstimate estimate;
    bool has_estimate = false;
  };
  Run run(const std::vector<std::string>& overrides) const {
    const mbs::PreparedMechanism p = mbs::prepare(file_, overrides);
    const auto shadows = Shadows::make(p);
    Run out;
    out.values = rows_of_run(p, [&](const mbs::State& s, const Eigen::VectorXd& v_dot) {
      if (shadows) shadows->take(s, v_dot);
    });
    out.has_estimate = shadows != nullptr;
    if (shadows) out.estimate = shadows->estimate();
    return out;
  }

  Folder folder_;
  std::filesystem::path file_;
};

TEST_F(ShadowsOfABar, GiveTheErrorOfALinearModelItself) {
  // Small deflections: the model is linear, so the corrected run is the one with all modes and the estimate
  // is the error (effectivity 1).  What differs is the shadows' fixed step: with h = 0.2 ms and the fastest
  // motion that carries energy (second clamped bending, 240 Hz: omega h = 0.3) generalised-alpha errs by
  // (omega h)^2 / 12 = 1 % of that part in phase per radian; the first mode and the load (omega h < 0.05)
  // carry nearly all of the deflection.  5 % bounds it.
  const Run truth = run({});
  EXPECT_FALSE(truth.has_estimate);
  for (const std::vector<std::string>& choice : {std::vector<std::string>{"body.beam.fidelity=rigid"},
                                                 {"body.beam.modes=1"},
                                                 {"body.beam.modes=3"},
                                                 {"body.beam.modes=5"}}) {
    const Run reduced = run(choice);
    ASSERT_TRUE(reduced.has_estimate);
    const double error = std::sqrt((reduced.values.col(0) - truth.values.col(0)).squaredNorm() /
                                   static_cast<double>(truth.values.rows()));
    ASSERT_EQ(reduced.estimate.outputs[0].name, "sway");
    EXPECT_NEAR(reduced.estimate.outputs[0].rms / error, 1.0, 0.05) << choice.front();
    EXPECT_EQ(reduced.estimate.by_body.at(0).body, "beam");
  }
}

TEST_F(ShadowsOfABar, OfAOneWayBodyGiveItsTruncation) {
  // The wall does not feel the beam, so one-way and coupled deformation are the same and what is left is the
  // truncation of its clamped modes; tolerance as above.
  const Run truth = run({});
  const Run reduced = run({"body.beam.fidelity=ked", "body.beam.modes=1", "body.beam.attachments=none"});
  ASSERT_TRUE(reduced.has_estimate);
  const double error = std::sqrt((reduced.values.col(0) - truth.values.col(0)).squaredNorm() /
                                 static_cast<double>(truth.values.rows()));
  EXPECT_NEAR(reduced.estimate.outputs[0].rms / error, 1.0, 0.05);
}

// A damping ratio is of the modes that frame and boundary condition make: against the same ratio of free modes a body of
// which nothing is left out was told to be 92 % off, for its damping alone.
TEST_F(ShadowsOfABar, TakeItsOwnFrameForTheMeaningOfItsDamping) {
  const std::vector<std::string> held = {"body.beam.frame=joint_fixed", "body.beam.damping=0.2"};
  const Run truth = run(held);
  EXPECT_FALSE(truth.has_estimate);
  std::vector<std::string> few = held;
  few.emplace_back("body.beam.modes=1");
  const Run reduced = run(few);
  ASSERT_TRUE(reduced.has_estimate);
  const double error = std::sqrt((reduced.values.col(0) - truth.values.col(0)).squaredNorm() /
                                 static_cast<double>(truth.values.rows()));
  EXPECT_NEAR(reduced.estimate.outputs[0].rms / error, 1.0, 0.05);  // as above
}

// Its matrices turn with the mechanism: where they lag, the correction grows with every turn, until an error
// of a few per mille is told as 100 %.  With rows h apart generalised-alpha errs by (omega h)^2 / 12 per
// radian in what turns with the shaft (omega h = 0.04: 4e-3 of it over these 32 radians), on the safe side
// here; ten times the error bounds that, and a third of it what the rows do not resolve.
TEST_F(ShadowsOfABar, StayNearTheErrorWhileTheMechanismTurns) {
  file_ = folder_.write("engine.toml", bars::kTurning);
  const Run truth = run({}), rigid = run({"body.beam.fidelity=rigid"});
  ASSERT_TRUE(rigid.has_estimate);
  for (std::size_t i = 0; i < rigid.estimate.outputs.size(); ++i) {
    const OutputEstimate& output = rigid.estimate.outputs[i];
    const auto column = static_cast<Eigen::Index>(i);
    const double error = std::sqrt((rigid.values.col(column) - truth.values.col(column)).squaredNorm() /
                                   static_cast<double>(truth.values.rows()));
    EXPECT_GT(output.rms, error / 3.0) << output.name;
    EXPECT_LT(output.rms, error * 10.0) << output.name;
  }
}

// Two bars on walls of their own; what is stored is of the first alone, and the second acts on it only later.
std::string two_bars(const std::string& between) {
  std::string text = R"toml(
gravity = [0, 0, 0]
[ground.marker.wall]
position = [0.3, -0.2, 0.1]
[ground.marker.other]
position = [0.3, 1, 0.1]
[body.read]
superelement = "beam.se.h5"
[body.other]
superelement = "beam.se.h5"
position = [0, 1.2, 0]
[joint.wall]
type = "fixed"
from = "ground.wall"
to = "read.left"
[joint.other]
type = "fixed"
from = "ground.other"
to = "other.left"
[force.tip]
type = "force"
marker = "read.right"
y = "10 * (1 - cos(150 * t))"
[force.far]
type = "force"
marker = "other.right"
y = "100 * (1 - cos(150 * t))"
[measure.sway]
type = "position"
from = "ground.wall"
to = "read.right"
direction = [0, 1, 0]
[measure.far_sway]
type = "position"
from = "ground.other"
to = "other.right"
direction = [0, 1, 0]
)toml";
  return text + between + R"toml(
[output]
quantities = ["sway"]
[solver]
end_time = "0.1 s"
output_step = "0.2 ms"
tolerance = 1e-8
)toml";
}

TEST_F(ShadowsOfABar, HaveABodyThatBeginsToMatterDuringTheRun) {
  const std::string couplings[] = {"1e4 * step(t, 0.04, 0, 0.05, 1) * far_sway",
                                   "t < 0.05 ? 0 : 1e4 * far_sway",
                                   "(t > 0.06 && t < 0.063 ? 2e4 : 0) * far_sway"};
  for (const std::string& coupling : couplings) {
    file_ = folder_.write(
        "two.toml",
        two_bars("[force.late]\ntype = \"force\"\nmarker = \"read.right\"\ny = \"" + coupling + "\"\n"));
    const Run truth = run({}), rigid = run({"body.read.fidelity=rigid", "body.other.fidelity=rigid"});
    ASSERT_TRUE(rigid.has_estimate);
    std::set<std::string> bodies;
    for (const SourceEstimate& source : rigid.estimate.by_body) bodies.insert(source.body);
    EXPECT_EQ(bodies, (std::set<std::string>{"read", "other"})) << coupling;
    const double error = std::sqrt((rigid.values.col(0) - truth.values.col(0)).squaredNorm() /
                                   static_cast<double>(truth.values.rows()));
    // Linear: tolerance as of a single bar, and half a row more or less of a pulse of fifteen.
    EXPECT_NEAR(rigid.estimate.outputs[0].rms / error, 1.0, 0.1) << coupling;
  }
}

// What is asked for reads the other bar by a formula that is level where the bars rest.
TEST_F(ShadowsOfABar, HaveABodyThatAnOutputIsLevelIn) {
  for (const std::string& formula :
       {"sway + max(far_sway - 1e-5, 0)", "far_sway > 1e-5 ? far_sway : sway", "sway + t * far_sway",
        "sway + step(far_sway, 1e-5, 0, 1e-4, 1)", "t < 0.05 ? sway : far_sway"}) {
    file_ = folder_.write("two.toml",
                          two_bars("[measure.over]\ntype = \"expression\"\nvalue = \"" + formula + "\"\n"));
    const Run rigid =
        run({"body.read.fidelity=rigid", "body.other.fidelity=rigid", "output.quantities=[\"over\"]"});
    ASSERT_TRUE(rigid.has_estimate);
    EXPECT_EQ(rigid.estimate.by_body.size(), 2u) << formula;
  }
}

TEST_F(ShadowsOfABar, HaveNoneThatNeverMatters) {
  file_ = folder_.write("two.toml", two_bars(""));
  const Run rigid = run({"body.read.fidelity=rigid", "body.other.fidelity=rigid"});
  ASSERT_TRUE(rigid.has_estimate);
  ASSERT_EQ(rigid.estimate.by_body.size(), 1u);
  EXPECT_EQ(rigid.estimate.by_body[0].body, "read");
}

// A body that is touched later: a block flies at the tip of a bar (0.05 m below) and comes back; where it is, is asked.
TEST_F(ShadowsOfABar, HaveABodyThatIsTouchedLater) {
  file_ = folder_.write("two.toml", two_bars(R"toml(
[ground.marker.rail]
position = [1.1, 0.95, 0.1]
axis = [0, 1, 0]
[body.block]
mass = 0.01
inertia = [1e-6, 1e-6, 1e-6]
[body.block.marker.rail]
axis = [0, 1, 0]
[joint.fly]
type = "prismatic"
from = "ground.rail"
to = "block.rail"
speed = 1
[body.other.marker.under]
on = "right"
axis = [0, -1, 0]
[force.touch]
type = "contact"
from = "other.under"
to = "block.rail"
radius = 0.01
stiffness = 1e4
)toml"));
  const Run rigid =
      run({"body.read.fidelity=rigid", "body.other.fidelity=rigid", "output.quantities=[\"fly.position\"]"});
  ASSERT_TRUE(rigid.has_estimate);
  ASSERT_EQ(rigid.estimate.by_body.size(), 1u);
  EXPECT_EQ(rigid.estimate.by_body[0].body, "other");
  EXPECT_GT(rigid.estimate.outputs[0].rms, 0.0);
}

// A load that is there at once sets off vibration that the rows do not show, and the wall takes the damping from the free bar's modes: the
// correction follows what rings as long as it does (a tenth of critical of the free modes is a hundredth here), looking into the first rows.
TEST_F(ShadowsOfABar, SeeTheVibrationWithWhichARunSetsOff) {
  const std::vector<std::string> sudden = {"force.tip.y=100", "body.beam.damping=0.1",
                                           "output.quantities=[\"wall.force_y\"]", "solver.end_time=0.32"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), sudden.begin(), sudden.end());
    return more;
  };
  const auto fine = with({"solver.output_step=0.2 ms"}),
             coarse = with({"solver.output_step=16 ms", "body.beam.fidelity=rigid"});
  const Run truth = run(fine);
  // What the rigid bar does is the same all along.
  const mbs::PreparedMechanism p = mbs::prepare(file_, coarse);
  const auto shadows = Shadows::make(p);
  ASSERT_NE(shadows, nullptr);
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
    shadows->take(s, v_dot);
  };
  shadows->ask_for_looks(callbacks,
                         [&](const mbs::State& s, const Eigen::VectorXd& v_dot) { shadows->look(s, v_dot); });
  ASSERT_TRUE(mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks).complete);
  const Run same = run(with({"solver.output_step=0.2 ms", "body.beam.fidelity=rigid"}));
  const double error = std::sqrt((same.values.col(0) - truth.values.col(0)).squaredNorm() /
                                 static_cast<double>(truth.values.rows()));
  // Twelve steps in a period: the phase is 2 % off in each radian, which an rms does not mind; 20 rows fall anywhere in it.
  EXPECT_NEAR(shadows->estimate().outputs.at(0).rms / error, 1.0, 0.2);
}

// A superelement that is too stiff by a part it knows, against the one that is not: a shape that is off, and vibrations that
// run ahead, over short runs and long ones, near a resonance (38 Hz) and off it.
TEST(ErrorsOfStiffness, AreWhatTheyChangeOfTheRun) {
  const test::Folder folder;
  const auto right = superelement::testing::make_box_beam();
  int large = 0;
  for (const double omega : {60.0, 150.0, 225.0, 300.0})
    for (const double end : {0.1, 0.6})
      for (const double e : {0.002, 0.02}) {
        SCOPED_TRACE(fmt::format("{} rad/s, {} s, {}", omega, end, e));
        auto stiff = right;
        stiff.K_se *= 1.0 + e;
        stiff.omega2 *= 1.0 + e;
        superelement::MeshError known;
        known.modes.push_back({.frequency_hz = 100.0, .error = 0.5 * e, .stress = {}});
        stiff.mesh_error = known;
        stiff.report_json = R"({"estimate":[{"frequency_hz":100.0,"frequency_error":0}]})";
        const auto rows = [&](const superelement::Superelement& se, bool tells) {
          superelement::write(folder / "beam.se.h5", se);
          const auto file = folder.write("m.toml", bars::kClamped);
          const auto p = mbs::prepare(
              file, {fmt::format("parameters.omega={}", omega), "body.beam.damping=0.005",
                     fmt::format("solver.end_time={}", end), "solver.tolerance=1e-7",
                     "output.quantities=[\"sway\"]", "solver.accuracy=0.01", "body.beam.fidelity=modal"});
          const int y = mbs::select_quantities(*p.mechanism, {"sway"}).front();
          const auto scratch = p.mechanism->make_scratch();
          std::vector<double> out;
          auto shadows = tells ? Shadows::make(p) : nullptr;
          mbs::RunCallbacks callbacks;
          callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
            Eigen::VectorXd value(1);
            p.mechanism->evaluate({y}, s, v_dot, *scratch, value);
            out.push_back(value(0));
            if (shadows) shadows->take(s, v_dot);
          };
          EXPECT_TRUE(mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks).complete);
          if (shadows) {
            const auto estimate = shadows->estimate();
            EXPECT_EQ(estimate.by_stiffness.size(), 1u);
            if (!estimate.by_stiffness.empty()) out.push_back(estimate.by_stiffness.front().error);
          }
          return out;
        };
        std::vector<double> of_stiff = rows(stiff, true);
        const std::vector<double> of_right = rows(right, false);
        ASSERT_EQ(of_stiff.size(), of_right.size() + 1);
        double squares = 0.0, sizes = 0.0;
        for (std::size_t i = 0; i < of_right.size(); ++i) {
          squares += std::pow(of_stiff[i] - of_right[i], 2);
          sizes += of_right[i] * of_right[i];
        }
        const double truth = std::sqrt(squares / sizes), said = of_stiff.back();
        // Rows 0.2 ms apart, 130 to a period: what the linear equation makes of its steps is 1e-3 of it.  To first order.
        if (truth < 0.2)
          EXPECT_NEAR(said, truth, 0.15 * truth);
        else
          EXPECT_GT(said, 0.1);
        large += truth > 2.0 * e;
      }
  EXPECT_GE(large, 4);  // far more than a part of the deformation
}

}  // namespace
}  // namespace flexura::study
