// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/choose.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mbs/mechanism/describe.hpp"
#include "mbs/study/choice/screening.hpp"
#include "mbs/study/choice/tolerance_choice.hpp"
#include "mbs/study/estimate/spectrum.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"
#include "tests/mbs/study/clamped_bar.hpp"
#include "tests/mbs/superelement/box_beam.hpp"

namespace flexura::study {
namespace {

using test::Folder;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// A slender beam on a driven shaft: 10 m, first clamped frequency 3.516 sqrt(EI / (m L^4)) = 3.80 rad/s.
const char* const kSpinning = R"toml(
gravity = [0, 0, 0]
[parameters]
omega = 6
T = 15
[ground.marker.shaft]
axis = [0, 0, 1]
[body.beam]
superelement = "slender.se.h5"
fidelity = "auto"
damping = 0.01
[body.beam.marker.hub]
on = "root"
axis = [0, 0, 1]
[joint.hub]
type = "revolute"
from = "ground.shaft"
to = "beam.hub"
drive = "t < T ? omega/T * (t^2/2 + (T/(2*pi))^2 * (cos(2*pi*t/T) - 1)) : omega * (t - T/2)"
[measure.deflection]
type = "position"
from = "beam.root"
to = "beam.tip"
direction = [0, 1, 0]
[output]
quantities = ["deflection"]
[solver]
end_time = "20 s"
output_step = "0.1 s"
)toml";

// Something for the clamped bar to knock against.
const char* const kBed = R"toml(
[ground.marker.bed]
position = [1.1, -0.205, 0.1]
axis = [0, 1, 0]
[force.bed]
type = "contact"
from = "ground.bed"
to = "beam.right"
radius = 0.005
stiffness = 1e6
damping = 100
)toml";

class Choosing : public ::testing::Test {
 protected:
  void SetUp() override {
    superelement::write(folder_ / "beam.se.h5", superelement::testing::make_box_beam());
    clamped_ = folder_.write("clamped.toml", bars::kClamped);
  }
  std::filesystem::path spinning() const {
    mbs::beams::StraightBeam b;
    b.length = 10.0;
    b.elements = 6;
    b.EA = 2.8e7;
    b.EI_z = b.EI_y = 1.4e4;
    b.GI_t = 1e4;
    b.mass_per_length = 1.2;
    b.rho_I_y = b.rho_I_z = 6e-4;
    superelement::write(folder_ / "slender.se.h5", mbs::beams::beam_superelement(b));
    return folder_.write("spinning.toml", kSpinning);
  }

  static ChosenRun run(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
    const mbs::PreparedMechanism given = mbs::prepare(file, overrides);
    EXPECT_TRUE(is_to_be_chosen(given));
    return run_within(given, {});
  }
  // The first output of every row.
  static Eigen::VectorXd values(const mbs::Mechanism& mechanism, const std::vector<RowOfRun>& rows,
                                const std::string& output) {
    const auto which = mbs::select_quantities(mechanism, {output});
    const auto scratch = mechanism.make_scratch();
    Eigen::VectorXd all(static_cast<Eigen::Index>(rows.size())), y(1);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      mechanism.evaluate(which, rows[i].state, rows[i].v_dot, *scratch, y);
      all(static_cast<Eigen::Index>(i)) = y(0);
    }
    return all;
  }
  static std::vector<RowOfRun> truth(const mbs::PreparedMechanism& p) {
    std::vector<RowOfRun> rows;
    mbs::RunCallbacks callbacks;
    callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount& energy) {
      rows.push_back({s, v_dot, energy});
    };
    EXPECT_TRUE(mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks).complete);
    return rows;
  }

  Folder folder_;
  std::filesystem::path clamped_;
};

TEST_F(Choosing, AStiffSlowSceneComesOutRigid) {
  // At 5 rad/s the reaction differs by (5 / 240)^2 = 0.04 %, and the deflection is not asked for.
  const ChosenRun slow = run(clamped_, {"solver.accuracy=0.01", "parameters.omega=5", "solver.end_time=1",
                                        "output.quantities=[\"wall.force\"]"});
  ASSERT_TRUE(slow.result.complete);
  EXPECT_THAT(slow.reasons, Contains(HasSubstr("beam: rigid: its deformation changes outputs by")));
  EXPECT_FALSE(slow.rows.empty());
  EXPECT_EQ(slow.restarts, 0);
}

// Rigid, the bar has no coordinate at all: IDA, which then fails beside a switch, has no state to name.
TEST_F(Choosing, AWeldedBarBetweenStopsIsChosenFor) {
  const auto file = folder_.write("stops.toml", std::string(bars::kClamped) + kBed);
  const ChosenRun chosen =
      run(file, {"solver.accuracy=0.01", "output.quantities=[\"sway\", \"bed.normal_force\"]"});
  ASSERT_TRUE(chosen.result.complete) << chosen.result.stopped_because;
  const mbs::PreparedMechanism p =
      mbs::prepare(file, {"solver.tolerance=1e-8", "output.quantities=[\"sway\"]"});
  const Eigen::VectorXd exact = values(*p.mechanism, truth(p), "sway"),
                        got = values(*chosen.prepared.mechanism, chosen.rows, "sway");
  ASSERT_EQ(exact.size(), got.size());
  EXPECT_LT((exact - got).norm(), 0.01 * exact.norm());
}

TEST_F(Choosing, ASlowLoadIsFollowedStatically) {
  // The deflection is wanted, and the load moves at a fiftieth of the first frequency.
  const ChosenRun slow = run(clamped_, {"solver.accuracy=0.05", "parameters.omega=5", "solver.end_time=1",
                                        "solver.output_step=2 ms", "output.quantities=[\"sway\"]"});
  ASSERT_TRUE(slow.result.complete);
  EXPECT_THAT(slow.reasons, Contains(HasSubstr("beam: static, ")));
}

TEST_F(Choosing, AFastSlenderSceneComesOutStiffened) {
  const std::filesystem::path file = spinning();
  const ChosenRun chosen = run(file, {});
  ASSERT_TRUE(chosen.result.complete) << chosen.result.stopped_because;
  EXPECT_THAT(chosen.reasons, Contains(HasSubstr("beam: modal-stiffened, ")));
  EXPECT_THAT(chosen.reasons, Contains(HasSubstr("spin and loads change its stiffness by")));
  EXPECT_THAT(chosen.reasons, Not(Contains(HasSubstr("tolerance"))));  // nobody asked for it
  // Against all modes with stiffening: within the 1 % that "auto" means without an accuracy.
  const mbs::PreparedMechanism p =
      mbs::prepare(file, {"body.beam.fidelity=modal-stiffened", "solver.tolerance=1e-6"});
  const Eigen::VectorXd exact = values(*p.mechanism, truth(p), "deflection"),
                        got = values(*chosen.prepared.mechanism, chosen.rows, "deflection");
  ASSERT_EQ(exact.size(), got.size());
  EXPECT_LT((exact - got).norm(), 0.01 * exact.norm());
}

// A steel bar as a pendulum, let go level.
const char* const kPendulum = R"toml(
[ground.marker.hook]
axis = [0, 1, 0]
[body.rope]
fidelity = "auto"
[body.rope.beam]
to = ["L", 0, 0]
diameter = "d"
young = "200 GPa"
density = "7800 kg/m^3"
elements = 2
[body.rope.marker.eye]
on = "root"
axis = [0, 1, 0]
[parameters]
L = 1
d = 0.001
[joint.hook]
type = "revolute"
from = "ground.hook"
to = "rope.eye"
[solver]
end_time = "0.5 ms"
output_step = "50 us"
)toml";

TEST_F(Choosing, ACableComesOutAsAnExactBeamAndABarRigid) {
  const std::filesystem::path file = folder_.write("pendulum.toml", kPendulum);
  const std::vector<std::string> falls = {"solver.end_time=0.2", "solver.output_step=20 ms"};
  const ChosenRun cable = run(file, falls);
  ASSERT_TRUE(cable.result.complete) << cable.result.stopped_because;
  // A wire of 1 mm and 1 m: under its weight of 0.06 N, clamped, q L^4 / (8 EI) = 0.77 m, EI = E pi d^4 / 64 = 0.0098 N m^2.
  EXPECT_THAT(cable.reasons, Contains(HasSubstr("its loads would bend it beyond what is linear in modes")));
  ASSERT_TRUE(cable.prepared.mechanism->description().bodies.back().flexible);
  EXPECT_FALSE(cable.prepared.mechanism->description().bodies.back().flexible->is_linear());
  EXPECT_EQ(cable.rows.size(), 11u);
  // In its plane alone it has half the coordinates, all in one body.
  const ChosenRun planar =
      run(file, {falls[0], falls[1], "body.rope.beam.planar=true", "body.rope.beam.y_axis=[0, 0, 1]"});
  EXPECT_THAT(planar.reasons, Contains(HasSubstr("its loads would bend it beyond what is linear in modes")));
  const auto& bent = planar.prepared.mechanism->description().bodies.back().flexible;
  ASSERT_TRUE(bent);
  EXPECT_TRUE(bent->stiff_direction());
  // 20 mm and 0.1 m: a part in a million of its length.
  const ChosenRun bar = run(file, {falls[0], falls[1], "parameters.L=0.1", "parameters.d=0.02",
                                   "output.quantities=[\"hook.angle\"]"});
  EXPECT_THAT(bar.reasons, ::testing::ElementsAre(HasSubstr("rope: rigid: ")));
}

TEST_F(Choosing, TheWantedAccuracyIsMet) {
  const mbs::PreparedMechanism p = mbs::prepare(clamped_, {});
  const Eigen::VectorXd exact = values(*p.mechanism, truth(p), "sway");
  for (const char* const accuracy : {"0.1", "0.01", "0.001"}) {
    const ChosenRun chosen = run(clamped_, {std::string("solver.accuracy=") + accuracy});
    ASSERT_TRUE(chosen.result.complete);
    const Eigen::VectorXd got = values(*chosen.prepared.mechanism, chosen.rows, "sway");
    ASSERT_EQ(exact.size(), got.size());
    EXPECT_LT((exact - got).norm(), std::stod(accuracy) * exact.norm()) << chosen.reasons.front();
  }
}

// A damping ratio is of the modes that frame and boundary condition make: the choice keeps a frame that the file gives, and is
// judged in it.
TEST_F(Choosing, AFrameThatTheFileGivesIsKept) {
  const std::vector<std::string> scene = {"body.beam.frame=joint_fixed", "body.beam.damping=0.2"};
  const mbs::PreparedMechanism p = mbs::prepare(clamped_, scene);
  const Eigen::VectorXd exact = values(*p.mechanism, truth(p), "sway");
  for (const char* const accuracy : {"0.01", "0.001"}) {
    std::vector<std::string> wanted = scene;
    wanted.push_back(std::string("solver.accuracy=") + accuracy);
    const ChosenRun chosen = run(clamped_, wanted);
    ASSERT_TRUE(chosen.result.complete);
    EXPECT_THAT(chosen.set, Not(Contains(HasSubstr("frame=mean_axis"))));
    EXPECT_LE(chosen.estimate.error, std::stod(accuracy));
    const Eigen::VectorXd got = values(*chosen.prepared.mechanism, chosen.rows, "sway");
    ASSERT_EQ(exact.size(), got.size());
    EXPECT_LT((exact - got).norm(), std::stod(accuracy) * exact.norm()) << chosen.reasons.front();
  }
}

TEST_F(Choosing, ARunThatProvesTheChoiceWrongGoesOnWithMore) {
  // The choice is that of an earlier run under a slow load alone; in this one a fast load fades in where the beam has bent by
  // 0.2 mm and shakes its second mode (clamped 240 Hz; the load 250 Hz).
  const std::string load =
      "force.tip.y=\"100*(1 - cos(5*t)) + omega*sin(1570*t) * 0.5*(1 + tanh((sway - 2e-4)/1e-4))\"";
  const std::vector<std::string> scene = {load, "solver.end_time=0.25", "output.quantities=[\"sway\"]",
                                          "body.beam.damping=0.02", "parameters.omega=15"};
  const auto cache = std::make_shared<mbs::PreparationCache>();
  const auto run_with = [&](const char* amplitude) {
    std::vector<std::string> wanted = scene;
    wanted.back() = std::string("parameters.omega=") + amplitude;
    wanted.push_back("solver.accuracy=0.05");
    return run_within(mbs::prepare(clamped_, wanted, {}, cache), {});
  };
  ASSERT_TRUE(run_with("0").result.complete);
  const ChosenRun chosen = run_with("15");
  ASSERT_TRUE(chosen.result.complete);
  EXPECT_GE(chosen.restarts, 1);
  EXPECT_THAT(chosen.reasons, Contains(HasSubstr("gone on from t = ")));
  // The rows stand at the same times as in one run, and the accuracy is met.
  const mbs::PreparedMechanism p = mbs::prepare(clamped_, scene);
  const std::vector<RowOfRun> rows = truth(p);
  const Eigen::VectorXd exact = values(*p.mechanism, rows, "sway"),
                        got = values(*chosen.prepared.mechanism, chosen.rows, "sway");
  ASSERT_EQ(exact.size(), got.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    EXPECT_NEAR(chosen.rows[i].state.t, rows[i].state.t, 1e-12);  // round-off of k h
  const double error = (exact - got).norm() / exact.norm();

  EXPECT_LT(error, 0.05);
  // What had been left out until it went on is not forgotten: "0, no mode left out" of a run with all modes since.
  ASSERT_TRUE(chosen.has_estimate);
  EXPECT_GT(chosen.estimate.error, 0.3 * error);
  EXPECT_LE(chosen.estimate.error, 0.05);
  EXPECT_THAT(chosen.estimate.by_body,
              Contains(::testing::Field(&SourceEstimate::error, ::testing::Gt(0.0))));
}

// What a choice costs is counted, never timed.
TEST_F(Choosing, TheScreeningGivesUpACandidateWhereItIsLost) {
  const std::vector<std::string> rigid = {"body.beam.fidelity=rigid", "solver.tolerance=1e-5"};
  const mbs::PreparedMechanism p = mbs::prepare(clamped_, rigid);
  const auto full = FullModel::make(p);
  ASSERT_TRUE(full);
  Screening screening(p, *full);
  long rows = 0;
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
    screening.take(s, v_dot);
    ++rows;
  };
  ASSERT_TRUE(mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks).complete);
  EXPECT_EQ(screening.effort().candidates, 0);
  // Nothing but every mode loses nothing: each bisection of the ladder is given up within the first rows, and every mode is
  // what the shadows of the run have followed already.
  EXPECT_TRUE(screening.cheapest("beam", 0.0).all);
  const Screening::Effort none = screening.effort();
  EXPECT_LE(none.candidates, 12);
  // Of 501 rows every second is compared.
  EXPECT_LE(none.rows, 3 * 2 * none.candidates);
  // Where candidates do, at most one in each step of a bisection is followed to the end.
  const Candidate some = screening.cheapest("beam", 0.01);
  EXPECT_FALSE(some.all);
  EXPECT_LE(some.loss, 0.01);
  const Screening::Effort both = screening.effort();
  EXPECT_LE(both.candidates - none.candidates, 12);
  EXPECT_LE(both.rows - none.rows, (both.candidates - none.candidates) * rows);
  // Any loss is as good as none where all may be lost: the first bisection takes response modes alone.
  EXPECT_EQ(screening.cheapest("beam", 1e9).modes, 0);
  EXPECT_LE(screening.effort().candidates - both.candidates, 4);
  // A part of the run is enough where it has lost too much: never where all may be lost, and of a run that is a hundred times as
  // long what is lost so far is a tenth.
  EXPECT_GT(screening.least_loss("beam", 0.0, screening.span()), 0.0);
  const double loss = screening.least_loss("beam", 1e9, screening.span());
  EXPECT_LE(loss, some.loss);
  EXPECT_NEAR(screening.least_loss("beam", 1e9, 100.0 * screening.span()), loss / 10.0, 1e-12 * loss);
}

// A loose one first; where the estimate is above 0.35 of the accuracy a finer one, once as E ~ tol^0.6 has it, then a thousandth of
// the accuracy, which is not watched any more.
TEST_F(Choosing, ToleranceFollowsWhatTheRunTellsOfItsIntegrator) {
  const mbs::PreparedMechanism smooth = mbs::prepare(clamped_);
  IntegratorEstimate told;
  ToleranceChoice choice(0.01, smooth);
  EXPECT_EQ(choice.value(), 3e-4);
  EXPECT_TRUE(choice.is_watched());
  EXPECT_TRUE(choice.is_too_much(0.0036));
  EXPECT_FALSE(choice.is_too_much(0.0034));
  told.error = 0.0024;
  EXPECT_FALSE(choice.has_to_be_finer(&told, 0.0, 0.005));
  told.error = 0.0033;  // beside 0.0045 of modes that is more than three quarters
  EXPECT_FALSE(ToleranceChoice(choice).has_to_be_finer(&told, 0.0, 0.0));
  EXPECT_TRUE(ToleranceChoice(choice).has_to_be_finer(&told, 0.0, 0.0045));
  told.error = 0.008;
  EXPECT_TRUE(choice.has_to_be_finer(&told, 0.0, 0.0));
  EXPECT_EQ(choice.value(), 2.4e-5);  // 3e-4 (0.175 / 0.8)^(1 / 0.6), to two digits
  EXPECT_TRUE(choice.has_to_be_finer(&told, 0.0, 0.0));
  EXPECT_EQ(choice.value(), 1e-5);
  EXPECT_FALSE(choice.is_watched());
  EXPECT_FALSE(choice.has_to_be_finer(&told, 0.0, 0.0));
  // What is not told, or energy that tells of more.
  ToleranceChoice unknown(0.01, smooth), leaps(0.01, smooth);
  EXPECT_TRUE(unknown.has_to_be_finer(nullptr, 0.0, 0.0));
  EXPECT_EQ(unknown.value(), 1e-5);
  told.error = 1e-4;
  EXPECT_TRUE(leaps.has_to_be_finer(&told, 0.02, 0.0));
  EXPECT_EQ(leaps.value(), 1e-5);
  // A contact switches.
  const auto stop = folder_.write("stop.toml", std::string(bars::kClamped) + kBed);
  const ToleranceChoice safe(0.01, mbs::prepare(stop));
  EXPECT_EQ(safe.value(), 1e-5);
  EXPECT_FALSE(safe.is_watched());
}

TEST_F(Choosing, OnlyOpenBodiesAreChosen) {
  EXPECT_FALSE(is_to_be_chosen(mbs::prepare(clamped_)));
  EXPECT_TRUE(is_to_be_chosen(mbs::prepare(clamped_, {"body.beam.fidelity=auto"})));
  const ChosenRun fixed =
      run(clamped_, {"solver.accuracy=0.1", "body.beam.fidelity=modal", "body.beam.modes=2"});
  EXPECT_THAT(fixed.reasons, ::testing::ElementsAre(HasSubstr("tolerance 1.0e-03")));
  EXPECT_THAT(fixed.set, Not(Contains("body.beam.modes=")));
}

TEST(Spectrum, ReachIsWhereTheHighestLineLies) {
  // Two lines, at 5 Hz and, with a hundredth of the power, at 40 Hz, sampled over two seconds: the window's
  // resolution is 2 / (n h) = 1 Hz.
  const Eigen::Index n = 1000;
  const double h = 2e-3;
  Eigen::MatrixXd y(n, 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = h * static_cast<double>(i);
    y(i, 0) =
        7.0 + std::sin(2.0 * std::numbers::pi * 5.0 * t) + 0.1 * std::sin(2.0 * std::numbers::pi * 40.0 * t);
  }
  EXPECT_NEAR(reach(y, h, 0.9), 5.0, 1.0);
  EXPECT_NEAR(reach(y, h, 0.999), 40.0, 1.0);
}

}  // namespace
}  // namespace flexura::study
