// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mbs/study/estimate/norms.hpp"
#include "mbs/study/study_file.hpp"
#include "tests/app/command.hpp"

/// Designs compared by `flexura study`: the values of their quantities against closed forms.
namespace flexura::study {
namespace {

using test::Folder;
using test::Outcome;
using test::read_text;
using test::replaced;
using ::testing::HasSubstr;

// A mass on a spring: x = 0.1 cos(omega t), omega = sqrt(k / 2).
const char* const kSpring = R"toml(
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
output_step = "1 ms"
)toml";

const char* const kDesigns = R"toml(
mechanism = "spring.toml"
[axis.stiffness]
key = "force.spring.stiffness"
values = ["50", "200", "800"]
[quantity.crossings]
of = "slide.position"
norm = "count"
level = 0.05
[quantity.speed]
of = "slide.speed"
norm = "peak"
[quantity.end]
of = "slide.position"
norm = "final"
[want]
least = ["crossings", "end"]
greatest = ["speed"]
finer = ["solver.tolerance=1e-9"]
)toml";

class Designs : public ::testing::Test {
 protected:
  void SetUp() override { folder_.write("spring.toml", kSpring); }
  Outcome study(const std::string& text) const {
    folder_.write("study.toml", text);
    return test::run("flexura", {"study", folder_ / "study.toml", "-o", folder_ / "out"});
  }
  nlohmann::json json() const { return nlohmann::json::parse(read_text(folder_ / "out.json")); }

  Folder folder_;
};

TEST(CountNorm, CountsRisesNotRowsAboveAndNotWhatBeginsAbove) {
  Signal s{Eigen::VectorXd::LinSpaced(9, 0.0, 1.0), Eigen::VectorXd(9)};
  s.value << 1, 1, -1, 0, 2, 3, -1, 0, 1;  // rises at rows 4 and 8; zero is not above
  EXPECT_EQ(value_of(s, Norm::count), 2.0);
  Signal none = s;
  none.value.setConstant(1.0);
  EXPECT_EQ(difference(none, s, Norm::count), 2.0);
}

TEST_F(Designs, HaveTheValuesOfTheClosedFormAndTheBestIsNamed) {
  const Outcome outcome = study(kDesigns);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto out = json();
  ASSERT_EQ(out.at("choices").size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const double omega = 5.0 * std::pow(2.0, static_cast<double>(i));
    const auto& values = out["choices"][i]["values"];
    const auto& known = out["choices"][i]["uncertainty"];
    // |cos(omega t)| rises above 1/2 at omega t = 2 pi / 3 + n pi.
    EXPECT_EQ(values[0], std::floor((omega - 2.0 * std::numbers::pi / 3.0) / std::numbers::pi) + 1.0);
    EXPECT_EQ(known[0], 0.0);
    // Rows of 1 ms miss the crest by (omega 0.5e-3)^2 / 2 = 5e-5 at most; the solution errs by less.
    EXPECT_NEAR(values[1].get<double>(), 0.1 * omega, 5e-5 * 0.1 * omega);
    EXPECT_NEAR(values[2].get<double>(), 0.1 * std::cos(omega), 1e-7);
    // What the first runs were off by is what the finer ones say, within what these are off by.
    EXPECT_GT(known[2], 1e-9);
    EXPECT_LT(known[2], 1e-4);
  }
  EXPECT_EQ(out["quantities"][0]["unit"], "");
  EXPECT_EQ(out["quantities"][1]["unit"], "m/s");
  EXPECT_THAT(outcome.out, HasSubstr("least crossings: stiffness 50 (1, known within 0)"));
  EXPECT_THAT(outcome.out, HasSubstr("least end: stiffness 200 (-0.08391 m, known within "));
  EXPECT_THAT(outcome.out, HasSubstr("greatest speed: stiffness 800 (2 m/s, known within "));
  EXPECT_THAT(read_text(folder_ / "out.csv"),
              HasSubstr("\"crossings\",\"uncertainty of crossings\",\"speed [m/s]\""));
  EXPECT_THAT(read_text(folder_ / "out.md"), HasSubstr("| stiffness 200 | 3 | 0 |"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.svg"));
}

TEST_F(Designs, ThatAreAlikeWithinTheirUncertaintyAreBothNamed) {
  // The third stiffness changes the end by 0.1 sin(10) dk / (4 omega) = 1.4e-10 m, below what tolerance 1e-4 leaves.
  std::string text = replaced(kDesigns, "\"50\", \"200\", \"800\"", "\"50\", \"200\", \"200.0000001\"");
  text = replaced(text, "[axis.stiffness]", "set = [\"solver.tolerance=1e-4\"]\n[axis.stiffness]");
  const Outcome outcome = study(text);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("; within the uncertainty as good: stiffness 200"));
}

TEST_F(Designs, WithoutFinerRunsTheUncertaintyIsUnknown) {
  const Outcome outcome = study(replaced(kDesigns, "finer = [\"solver.tolerance=1e-9\"]", ""));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("stiffness 50 (1, how far it is known is unknown: give finer)"));
  EXPECT_TRUE(json()["choices"][0]["uncertainty"][0].is_null());
}

TEST_F(Designs, OfEqualValueAreBothNamedThoughTheirUncertaintyIsUnknown) {
  // 10 and 10.02 rad/s for 1 s: three crossings each (the closed form above).
  std::string text = replaced(kDesigns, "\"50\", \"200\", \"800\"", "\"200\", \"201\", \"800\"");
  const Outcome outcome = study(replaced(text, "finer = [\"solver.tolerance=1e-9\"]", ""));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("within the uncertainty as good: stiffness 201\n"));
}

TEST_F(Designs, WhoseFinerRunFailsMayBeBetter) {
  // 200 steps are enough at the study's tolerance, not at 1e-11: that value stands, without its uncertainty.
  std::string text = replaced(kDesigns, "key = \"force.spring.stiffness\"", "key = \"solver.max_steps\"");
  text = replaced(text, "\"50\", \"200\", \"800\"", "\"0\", \"200\"");
  const Outcome outcome = study(replaced(text, "tolerance=1e-9", "tolerance=1e-11"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("perhaps better, how far they are known is unknown: max_steps 200"));
}

TEST_F(Designs, ThatFailAreToldAndNotTheBest) {
  // Three steps are not enough for a period and a half; 0 is no bound.
  const Outcome outcome =
      study(replaced(replaced(kDesigns, "key = \"force.spring.stiffness\"", "key = \"solver.max_steps\""),
                     "\"50\", \"200\", \"800\"", "\"3\", \"0\""));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("least crossings: max_steps 0 (3, known within 0)"));
  EXPECT_THAT(outcome.out, HasSubstr("note: max_steps 3: "));
  EXPECT_TRUE(json()["choices"][0]["values"][0].is_null());
}

TEST_F(Designs, RefusalsNameWhatToWrite) {
  const auto refused = [&](const std::string& text) {
    const Outcome outcome = study(text);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(refused(replaced(kDesigns, "least = [\"crossings\"", "least = [\"crossing\"")),
              HasSubstr("there is no quantity \"crossing\""));
  EXPECT_THAT(refused(std::string(kDesigns) + "accuracy = [\"1 %\"]\n"),
              HasSubstr("asks for errors, least and greatest for values; make two studies of it"));
  EXPECT_THAT(refused(std::string(kDesigns) + "[reference.check.one]\nset = [\"solver.tolerance=1e-10\"]\n"),
              HasSubstr("finer says how far each value is known"));
  EXPECT_THAT(refused(replaced(replaced(kDesigns, "least = [\"crossings\", \"end\"]", ""),
                               "greatest = [\"speed\"]", "")),
              HasSubstr("belongs to least and greatest"));
}

}  // namespace
}  // namespace flexura::study
