// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// What a run says of its own error: what nothing judged is unknown, and what is zero is no measure.
namespace flexura::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::filesystem::path kFound = std::filesystem::path(FLEXURA_SOURCE_DIR) / "tests/found";

class Estimates : public ::testing::Test {
 protected:
  struct Run {
    Outcome text;
    nlohmann::json estimate;
    bool has_unknown(const std::string& source, const std::string& name) const {
      for (const auto& u : estimate.at("unknown"))
        if (u.at("source") == source && u.at("name") == name) return true;
      return false;
    }
  };
  Run simulate(const std::filesystem::path& file, const std::vector<std::string>& set,
               const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"simulate", file.string(), "-o", (folder_ / "out.h5").string()};
    for (const std::string& s : set) arguments.insert(arguments.end(), {"--set", s});
    arguments.insert(arguments.end(), more.begin(), more.end());
    Run run{test::run("flexura", arguments), {}};
    EXPECT_EQ(run.text.exit_code, 0) << run.text.err;
    arguments.push_back("--json");
    const Outcome json = test::run("flexura", arguments);
    if (json.exit_code == 0)
      run.estimate = nlohmann::json::parse(json.out).at("runs").at(0).at("summary").at("estimate");
    return run;
  }
  void reduce(const std::filesystem::path& part) const {
    const Outcome out = test::run(
        "flexura",
        {"reduce", part.string(), "-o", (folder_ / (part.stem().string() + ".se.h5")).string(), "--quiet"});
    ASSERT_EQ(out.exit_code, 0) << out.err;
  }
  Folder folder_;
};

// A hit of 1 ms on a bar that is to keep 3 of its 32 modes or none, seen at rows 0.1 to 3 ms apart: between two of them the
// hit was over, and "no mode left out". The estimate looks where the load is; the rows change nothing.
TEST_F(Estimates, AHitBetweenRowsIsJudged) {
  reduce(kFound / "trade/ringer.toml");
  const std::string text = read_text(kFound / "trade/scene_impulse_late.toml");
  folder_.write("hit.toml", text);
  for (const std::vector<std::string>& few :
       {std::vector<std::string>{"body.bar.modes=3"}, {"body.bar.modes=", "body.bar.fidelity=rigid"}}) {
    std::vector<double> said;
    for (const char* const step : {"0.1 ms", "0.5 ms", "3 ms"}) {
      std::vector<std::string> set = few;
      set.insert(set.end(), {"solver.end_time=0.6", std::string("solver.output_step=\"") + step + "\""});
      const Run run = simulate(folder_ / "hit.toml", set);
      EXPECT_FALSE(run.has_unknown("modes", "bar")) << step;
      said.push_back(run.estimate.at("truncation").get<double>());
    }
    // Behind the hit the modes that are kept ring faster than rows 3 ms apart show, and drive what is left out.
    EXPECT_NEAR(said[1] / said[0], 1.0, 0.1) << few.front();
    EXPECT_NEAR(said[2] / said[0], 1.0, 0.5) << few.front();
    // Rigid it has none of what rings.
    if (few.size() == 2) {
      EXPECT_GT(said[0], 0.9);
    }
  }
}

// Three parallel cranks at 2 rad/s have no angular acceleration at all: what is computed of it, 1e-8 rad/s^2 beside
// 0.3 m (2 rad/s)^2, is noise, and was called wrong by 5 % of itself. All speeds are constant and the motion is a circle, to
// the tolerance of 1e-6.
TEST_F(Estimates, AFamilyThatIsZeroIsNoMeasure) {
  for (const char* const method : {"ida", "generalised_alpha"}) {
    const Run run =
        simulate(kFound / "estimates/three_cranks.toml", {std::string("solver.method=") + method});
    EXPECT_LT(run.estimate.at("error").get<double>(), 1e-5) << method << run.text.out;
  }
}

// What a dropped deformation does to a motor or a filter comes back through their states. Said 1.2 % where 15 % was true, of a rigid
// arm, and with an accuracy of 10 % the arm was left rigid. The truth is the run with all modes at a thousandth of the
// tolerance; estimates to first order of some 10 % are right within half of themselves.
TEST_F(Estimates, DeformationsComeBackThroughStates) {
  reduce(kFound / "estimates/soft_arm.toml");
  folder_.write("arm.toml", read_text(kFound / "estimates/arm_by_motor.toml"));
  const auto rows = [&] { return results::read(folder_ / "out.h5").runs.at(0).values; };
  simulate(folder_ / "arm.toml", {"solver.tolerance=1e-9"});
  const Eigen::MatrixXd truth = rows();
  // The four quantities of the file stand first.
  const auto off = [&](const Eigen::MatrixXd& run) {
    return (run - truth)
        .leftCols(4)
        .colwise()
        .norm()
        .cwiseQuotient(truth.leftCols(4).colwise().norm())
        .maxCoeff();
  };
  for (const char* const few : {"body.arm.fidelity=rigid", "body.arm.modes=2", "body.arm.modes=4"}) {
    const Run run = simulate(folder_ / "arm.toml", {few, "solver.tolerance=1e-8"});
    EXPECT_FALSE(run.has_unknown("modes", "arm"));
    const double error = off(rows());
    EXPECT_GT(error, 0.02) << few;
    EXPECT_NEAR(run.estimate.at("truncation").get<double>() / error, 1.0, 0.5) << few;
  }
  simulate(folder_ / "arm.toml", {"body.arm.fidelity=auto"}, {"--accuracy", "10 %"});
  EXPECT_LT(off(rows()), 0.1);
}

// A control that samples the motion makes what is left out ring at every jump, which nothing follows.
TEST_F(Estimates, ModesLeftOutOfASampledLoopAreUnknown) {
  reduce(kFound / "estimates/soft_arm.toml");
  const std::string text = replaced(read_text(kFound / "estimates/arm_by_motor.toml"),
                                    "type = \"filter\"\ninput = \"tip\"\ntime_constant = \"1 ms\"",
                                    "type = \"sample\"\ninput = \"tip\"\nperiod = \"1 ms\"");
  const Run run = simulate(folder_.write("arm.toml", text), {"body.arm.fidelity=rigid", "solver.end_time=1"});
  EXPECT_TRUE(run.has_unknown("modes", "arm"));
  EXPECT_THAT(run.text.out, HasSubstr("what the jumps of the"));
  // One that samples a command alone leaves the loop as it is.
  const Run open =
      simulate(folder_.write("open.toml", replaced(text, "input = \"tip\"", "input = \"0.5*t\"")),
               {"body.arm.fidelity=rigid", "solver.end_time=1"});
  EXPECT_FALSE(open.has_unknown("modes", "arm"));
}

// "0  no mode left out" where a subsystem's body kept 2 of its 22: now as one of the file's own.
TEST_F(Estimates, ModesLeftOutOfASubsystemsBodyAreJudged) {
  reduce(kFound / "trade/ringer.toml");
  const std::string text = read_text(kFound / "trade/scene_impulse_late.toml");
  folder_.write("hit.toml", text);
  folder_.write("two.toml",
                "gravity = [0, 0, 0]\n[subsystem.inner]\nfile = \"hit.toml\"\n"
                "[output]\nquantities = [\"inner.wall.torque_y\", "
                "\"inner.wall.force_z\"]\n[solver]\nend_time = 0.6\noutput_step = 5e-4\n");
  const std::vector<std::string> alone = {"body.bar.modes=3", "solver.end_time=0.6",
                                          "solver.output_step=5e-4",
                                          "output.quantities=[\"wall.torque_y\", \"wall.force_z\"]"};
  const double said = simulate(folder_ / "hit.toml", alone).estimate.at("truncation").get<double>();
  EXPECT_GT(said, 1e-6);
  const Run run = simulate(folder_ / "two.toml", {"subsystem.inner.body.bar.modes=3"});
  EXPECT_NEAR(run.estimate.at("truncation").get<double>() / said, 1.0, 0.01) << run.text.out;
  EXPECT_THAT(run.text.out, HasSubstr("modes left out of inner.bar"));
}

// The stress at a sharp re-entrant edge: 16, 26 and 36 MPa with one, two and four elements in 10 mm, and "1.3 %, of its deformation"
// was all that the run said. Away from the edge (11.7, 11.99 and 12.00 MPa) nothing judges it, either.
TEST_F(Estimates, StressesHaveErrorsOfTheirOwn) {
  reduce(kFound / "estimates/bracket.toml");
  folder_.write("bracket.toml", read_text(kFound / "estimates/bracket_pressed.toml"));
  const Run greatest = simulate(folder_ / "bracket.toml", {"output.quantities=[\"bracket.von_mises\"]"},
                                {"--accuracy", "20 %"});
  EXPECT_TRUE(greatest.has_unknown("stress", "bracket")) << greatest.text.out;
  EXPECT_THAT(greatest.text.out, HasSubstr("no finite stress"));
  EXPECT_THAT(greatest.text.err,
              HasSubstr("is met is unknown: nothing judges stress of bracket by its mesh"));
  // What is known of elements is no figure of what stands at a point.
  const Run leg = simulate(folder_ / "bracket.toml", {"output.quantities=[\"bracket.leg.von_mises\"]"});
  EXPECT_TRUE(leg.has_unknown("stress", "bracket"));
  EXPECT_THAT(leg.text.out, HasSubstr("in elements it is off by"));
  // Without stresses among the outputs nothing is said of them.
  const Run tip = simulate(folder_ / "bracket.toml", {"output.quantities=[\"clamp.force_z\"]"});
  EXPECT_THAT(tip.text.out, Not(HasSubstr("stress of")));
}

// More hits than can be looked at, and rows between them: what nothing looks at judges no mode.
TEST_F(Estimates, RowsThatMissALoadJudgeNoMode) {
  reduce(kFound / "trade/ringer.toml");
  const std::string text = read_text(kFound / "trade/scene_impulse_late.toml");
  const Run missed =
      simulate(folder_.write("hits.toml", replaced(text, "t>0.5 && t<0.501 ? 200*sin(pi*(t-0.5)/0.001)^2 : 0",
                                                   "mod(t, 0.01) < 0.0001 ? 20 : 0")),
               {"body.bar.modes=3", "solver.output_step=\"5 ms\"", "solver.end_time=1"});
  EXPECT_TRUE(missed.has_unknown("modes", "bar"));
  EXPECT_THAT(missed.text.out, HasSubstr("forces change within 0.0001"));
  EXPECT_THAT(missed.text.out, Not(HasSubstr(": ;")));
}

// 29, 11 and 5.5 % wrong with one, two and three segments, and "estimated error 8e-07 %": nothing had judged
// how many there are.
TEST_F(Estimates, ElementsOfBeamsAreUnknown) {
  for (const char* const fidelity : {"segments", "ancf"}) {
    const Run run = simulate(kFound / "flex/segments/cant.toml",
                             {"solver.end_time=0.05", std::string("body.u.fidelity=") + fidelity});
    EXPECT_THAT(run.text.out, HasSubstr("estimated error at least "));
    EXPECT_THAT(run.text.out, HasSubstr("elements of u: --check-elements tells"));
    EXPECT_TRUE(run.estimate.at("error").is_null());
    EXPECT_TRUE(run.estimate.at("integrator").is_number());
    EXPECT_TRUE(run.has_unknown("elements", "u"));
    const Run judged =
        simulate(kFound / "flex/segments/cant.toml",
                 {"solver.end_time=0.05", std::string("body.u.fidelity=") + fidelity}, {"--check-elements"});
    EXPECT_FALSE(judged.has_unknown("elements", "u"));
    EXPECT_GT(judged.estimate.at("error").get<double>(), 0.01);
  }
  // A rigid beam has none.
  const Run rigid = simulate(kFound / "flex/segments/cant.toml",
                             {"solver.end_time=0.05", "body.u.fidelity=rigid", "joint.a.type=revolute"});
  EXPECT_FALSE(rigid.has_unknown("elements", "u"));
}

// A hinge without a drive has no torque about its pin. What the first order leaves of it, 1e-3 N m beside 10 N at 0.7 m, was
// 100 % of the worst output. The share of the bar's deformation in the hinge's force is some percent.
TEST_F(Estimates, WhatCancelsInAnOutputIsNoMeasure) {
  const std::string part = read_text(kFound / "estimates/bar.toml"),
                    scene = read_text(kFound / "estimates/two_hinges.toml");
  std::mt19937 random(20261128);
  std::uniform_real_distribution<double> factor(0.7, 1.4);
  for (int i = 0; i < 12; ++i) {
    reduce(folder_.write("bar.toml", replaced(part, "0.719", fmt::format("{:.4f}", 0.719 * factor(random)))));
    const Run run =
        simulate(folder_.write("scene.toml", scene),
                 {fmt::format("body.tip.mass={}", 0.083 * factor(random)),
                  fmt::format("parameters.F={}", 16.9 * factor(random)),
                  fmt::format("parameters.W={}", 23.8 * factor(random)),
                  fmt::format("solver.tolerance={}", std::pow(10.0, -4.0 - 4.0 * factor(random) / 1.4))});
    const nlohmann::json& outputs = run.estimate.at("outputs");
    for (const char* const joint : {"j0", "j1"}) {
      const auto share = [&](const char* quantity) {
        const nlohmann::json& o = outputs.at(std::string(joint) + quantity);
        return o.at("rms").get<double>() / o.at("scale").get<double>();
      };
      EXPECT_LT(share(".torque"), 0.1 * share(".force")) << i;
    }
    EXPECT_THAT(run.text.out, Not(HasSubstr("torque"))) << i;
  }
}

// The largest displacement of a link, 1e-4 of where the link is: what few modes leave out of it is told of itself, against the run with all modes.
TEST_F(Estimates, TheLargestDisplacementOfABodyIsJudgedByItself) {
  const std::filesystem::path tutorial =
      std::filesystem::path(FLEXURA_SOURCE_DIR) / "docs/tutorials/four_bar";
  reduce(tutorial / "link.toml");
  folder_.write("m.toml", read_text(tutorial / "flexible.toml"));
  const auto displacement = [&](int modes, double* told) {
    const Run run = simulate(folder_ / "m.toml",
                             {"body.coupler.displacement=true", fmt::format("body.coupler.modes={}", modes),
                              "body.coupler.damping=0.05", "solver.initial_deformation=quasi_static",
                              "output.quantities=[\"coupler.displacement\"]"},
                             {"--run", "flexible"});
    if (told) *told = run.estimate.at("truncation").get<double>();
    return Eigen::VectorXd(results::read(folder_ / "out.h5").runs.at(0).values.col(0));
  };
  const Eigen::VectorXd all = displacement(12, nullptr);
  for (const int modes : {1, 2, 3, 5, 8}) {
    double told = 0.0;
    const double error = (displacement(modes, &told) - all).norm() / all.norm();
    EXPECT_GT(told, 0.3 * error) << modes;
    EXPECT_LT(told, 3.0 * error) << modes;
  }
}

// What is judged is not called unknown: rigid bodies and a second run.
TEST_F(Estimates, ASecondRunJudgesTheIntegrator) {
  const Run run =
      simulate(kFound / "rigid/check_integrator_noise.toml", {"solver.end_time=0.5"}, {"--check-integrator"});
  EXPECT_THAT(run.text.out, Not(HasSubstr("at least")));
  EXPECT_TRUE(run.estimate.at("error").is_number());
  EXPECT_TRUE(run.estimate.at("unknown").empty());
}

// The contact of a roller, against the second run and without it.
TEST_F(Estimates, AContactIsUnknownUnlessASecondRunSawIt) {
  const std::filesystem::path file = kFound / "rigid/ida_stalls_roller_contact.toml";
  const std::vector<std::string> set = {"solver.end_time=0.05", "solver.method=radau",
                                        "solver.tolerance=1e-6"};
  EXPECT_TRUE(simulate(file, set).has_unknown("switch", "c"));
  EXPECT_FALSE(simulate(file, set, {"--check-integrator"}).has_unknown("switch", "c"));
}

// The car axis is right to 0.002 % (a run at 1e-12); r.force_y, which the planar joint does not transmit, is
// noise of Newton's method, and so is its relative difference to another run.
TEST_F(Estimates, NoiseIsJudgedAgainstItsFamily) {
  for (const char* const method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    const Run run = simulate(kFound / "rigid/check_integrator_noise.toml",
                             {std::string("solver.method=") + method}, {"--check-integrator"});
    EXPECT_LT(run.estimate.at("error").get<double>(), 5e-3) << method << run.text.out;
    EXPECT_GT(run.estimate.at("error").get<double>(), 0.0) << method;
  }
}

// A planar four-bar of flexible bars: what stands across its plane is zero.
TEST_F(Estimates, QuantitiesThatAreZeroAreNotAHundredPercentWrong) {
  const std::filesystem::path from = kFound / "flex/estimate_zero";
  for (const char* const bar : {"bar1", "bar2", "bar3"}) reduce(from / (std::string(bar) + ".toml"));
  std::filesystem::copy_file(from / "fb_5.toml", folder_ / "fb_5.toml");
  const Run run = simulate(folder_ / "fb_5.toml", {"solver.end_time=0.5", "parameters.W=2"});
  EXPECT_LT(run.estimate.at("at_least").get<double>(), 0.05) << run.text.out;
}

// A superelement without terms for geometric stiffening; with them it is no source.
TEST_F(Estimates, StiffeningWithoutTermsIsUnknown) {
  const std::filesystem::path part = kFound / "flex/segments/l1.toml";
  std::filesystem::copy_file(kFound / "flex/segments/cm.toml", folder_ / "cm.toml");
  reduce(part);
  const std::vector<std::string> set = {"solver.end_time=0.02"};
  EXPECT_FALSE(simulate(folder_ / "cm.toml", set).has_unknown("stiffening", "u"));
  reduce(folder_.write("l1.toml", replaced(read_text(part), "stiffening=true", "stiffening=false")));
  EXPECT_TRUE(simulate(folder_ / "cm.toml", set).has_unknown("stiffening", "u"));
}

}  // namespace
}  // namespace flexura::test
