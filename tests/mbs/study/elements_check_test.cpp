// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/elements_check.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "mbs/study/choice/choose.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/study/rows_of_run.hpp"

/// What the number of elements costs, against closed forms.
namespace flexura::study {
namespace {

using ::testing::HasSubstr;

TEST(ObservedOrders, AreThoseOfThePowersThatMadeTheDifferences) {
  for (const std::array<double, 3>& h : {std::array{1.0, 2.0, 4.0}, {1.0, 1.8, 3.0}, {0.25, 0.5, 1.0}})
    for (const double p : {1.0, 2.0, 3.5}) {
      const auto e = [&](std::size_t i) { return 0.3 * std::pow(h[i], p); };
      EXPECT_NEAR(observed_order(h, e(1) - e(0), e(2) - e(1)), p,
                  1e-5);  // the bisection's 1e-6, and round-off
    }
  EXPECT_EQ(observed_order({1, 2, 4}, 1.0, 100.0), 4.0);
  // Halves do not come nearer at all, or by less than the first power.
  EXPECT_EQ(observed_order({1, 2, 4}, 1.0, 1.0), 0.0);
  EXPECT_EQ(observed_order({1, 2, 4}, 1.0, 1.6), 0.0);
}

constexpr double kLength = 1.0, kWidth = 0.008, kYoung = 70e9, kDensity = 2700.0, kGravity = 9.81, kEnd = 0.1;

// A clamped bar let go in its weight, which acts along its width.
std::string bar(const std::string& fidelity, int elements) {
  return fmt::format(R"toml(name = "bar"
gravity = [0, {}, 0]
[body.bar]
fidelity = "{}"
[body.bar.beam]
to = [{}, 0, 0]
elements = {}
young = {}
poisson = 0.3
density = {}
width = {}
height = "20 mm"
[joint.clamp]
type = "fixed"
from = "ground"
to = "bar.root"
[measure.y]
type = "position"
from = "ground"
to = "bar.tip"
direction = [0, 1, 0]
[output]
quantities = ["y"]
[solver]
method = "radau"
end_time = {}
output_step = "0.5 ms"
tolerance = 1e-7
)toml",
                     -kGravity, fidelity, kLength, elements, kYoung, kDensity, kWidth, kEnd);
}

// Its tip by Euler-Bernoulli: modes phi_i with phi_i(L) = 2 (-1)^(i+1), int phi_i = 2 sigma_i L / beta_i, int phi_i^2 = L
// (Blevins, Formulas for Natural Frequency and Mode Shape, table 8-1).  Shear and rotary inertia of this bar
// change its first frequency by 5e-5 (Timoshenko).
double exact_tip(double t) {
  const std::array<double, 5> beta = {1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839};
  double y = 0.0;
  for (std::size_t i = 0; i < beta.size(); ++i) {
    const double sigma = (std::sinh(beta[i]) - std::sin(beta[i])) / (std::cosh(beta[i]) + std::cos(beta[i]));
    const double omega =
        beta[i] * beta[i] / (kLength * kLength) * std::sqrt(kYoung * kWidth * kWidth / 12.0 / kDensity);
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    y -= kGravity / (omega * omega) * 2.0 * sign * 2.0 * sigma / beta[i] * (1.0 - std::cos(omega * t));
  }
  return y;
}

struct Judged {
  double truth = 0.0;
  ElementsEstimate estimate;
};

Judged judge(const std::string& fidelity, int elements) {
  const test::Folder folder;
  const auto file = folder.write("bar.toml", bar(fidelity, elements));
  const mbs::PreparedMechanism p = mbs::prepare(file);
  const auto check = ElementsCheck::make(p);
  Judged out;
  double squares = 0.0, sizes = 0.0;
  const int y = mbs::select_quantities(*p.mechanism, {"y"}).front();
  const auto scratch = p.mechanism->make_scratch();
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
    check->take(s, v_dot);
    Eigen::VectorXd value(1);
    p.mechanism->evaluate({y}, s, v_dot, *scratch, value);
    const double exact = exact_tip(s.t);
    squares += (value(0) - exact) * (value(0) - exact);
    sizes += exact * exact;
  };
  const mbs::RunResult result = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  EXPECT_TRUE(result.complete) << result.stopped_because;
  out.truth = std::sqrt(squares / sizes);
  out.estimate = check->estimate({}, result.wall_time);
  return out;
}

struct Case {
  const char* fidelity;
  int elements;
};

class ElementsOfBeams : public ::testing::TestWithParam<Case> {};

// Within a factor of three, or unknown and at least so many; below a thousandth the model of the closed form ends.
TEST_P(ElementsOfBeams, AreJudgedAgainstTheClosedForm) {
  const Judged judged = judge(GetParam().fidelity, GetParam().elements);
  RecordProperty("truth", fmt::format("{:.3g}", judged.truth));
  RecordProperty("estimate", fmt::format("{:.3g}", judged.estimate.error));
  // On a slow machine, or under a sanitizer, that is right to say.
  if (judged.estimate.note.find("takes longer than") != std::string::npos)
    GTEST_SKIP() << judged.estimate.note;
  if (!judged.estimate.is_whole) {
    EXPECT_GT(judged.truth, 0.01) << "unknown although it converges: " << judged.estimate.note;
    return;
  }
  EXPECT_LT(judged.estimate.error, std::max(3.0 * judged.truth, 3e-3)) << judged.estimate.note;
  EXPECT_GT(judged.estimate.error, judged.truth / 3.0 - 1e-3) << judged.estimate.note << judged.truth;
}

INSTANTIATE_TEST_SUITE_P(Fidelities, ElementsOfBeams,
                         ::testing::Values(Case{"segments", 1}, Case{"segments", 2}, Case{"segments", 3},
                                           Case{"segments", 4}, Case{"segments", 9}, Case{"ancf", 2},
                                           Case{"ancf", 8}, Case{"beam", 1}, Case{"beam", 2},
                                           Case{"beam", 4}),
                         [](const auto& info) {
                           return fmt::format("{}{}", info.param.fidelity, info.param.elements);
                         });

// Relative to `wanted`, of the rows of a run.
double error_of_tip(const ChosenRun& run, const std::function<double(double)>& wanted) {
  const int y = mbs::select_quantities(*run.prepared.mechanism, {"y"}).front();
  const auto scratch = run.prepared.mechanism->make_scratch();
  double squares = 0.0, sizes = 0.0;
  for (const RowOfRun& row : run.rows) {
    Eigen::VectorXd value(1);
    run.prepared.mechanism->evaluate({y}, row.state, row.v_dot, *scratch, value);
    squares += std::pow(value(0) - wanted(row.state.t), 2);
    sizes += std::pow(wanted(row.state.t), 2);
  }
  return std::sqrt(squares / sizes);
}

TEST(ABeamForAnAccuracy, BendsInItsModesWhileThatIsLittle) {
  const test::Folder folder;
  const auto file = folder.write("bar.toml", bar("auto", 1));
  const std::vector<std::string> words = {"solver.accuracy=0.001"};
  const ChosenRun chosen = run_within(mbs::prepare(file, words), {});
  ASSERT_TRUE(chosen.result.complete) << chosen.result.stopped_because;
  EXPECT_THAT(chosen.set, ::testing::Contains("body.bar.fidelity=modal"));
  EXPECT_LT(error_of_tip(chosen, exact_tip), 1e-3);
}

// An accuracy asked for is met by as many elements as it takes.
TEST(ElementsForAnAccuracy, AreAsManyAsItTakes) {
  const test::Folder folder;
  const auto file = folder.write("bar.toml", bar("auto", 1));
  // Twenty times its weight bends it by a third of its length.
  const std::vector<std::string> words = {"gravity=[0, -200, 0]", "solver.end_time=0.06",
                                          "solver.accuracy=0.002"};
  const ChosenRun chosen = run_within(mbs::prepare(file, words), {});
  ASSERT_TRUE(chosen.result.complete) << chosen.result.stopped_because;
  EXPECT_THAT(chosen.set, ::testing::Contains("body.bar.fidelity=beam"));
  EXPECT_THAT(chosen.set, ::testing::Contains("body.bar.beam.elements=4"));
  ASSERT_TRUE(chosen.elements);
  EXPECT_TRUE(chosen.elements->is_whole);
  EXPECT_LT(chosen.elements->error, 1e-3);
  // Against 8 elements, whose error is a sixteenth.
  const auto p = mbs::prepare(file, {words[0], words[1], "solver.tolerance=1e-5", "body.bar.fidelity=beam",
                                     "body.bar.beam.elements=8"});
  std::map<double, double> fine;
  const int y = mbs::select_quantities(*p.mechanism, {"y"}).front();
  const auto scratch = p.mechanism->make_scratch();
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
    Eigen::VectorXd value(1);
    p.mechanism->evaluate({y}, s, v_dot, *scratch, value);
    fine[s.t] = value(0);
  };
  ASSERT_TRUE(mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks).complete);
  EXPECT_LT(error_of_tip(chosen, [&](double t) { return fine.lower_bound(t - 1e-9)->second; }), 2e-3);
}

}  // namespace
}  // namespace flexura::study
