// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/mbs/app/flexura_fixture.hpp"

/// What commands print for people, for scripts: --json.
namespace flexura {
namespace {

using testing::Flexura;
using ::testing::HasSubstr;
using testing::Outcome;

// A block of 2 kg on an upright guide, g = 10 m/s^2.
constexpr const char* kBlockOnGuide = R"toml(gravity = [0, 0, -10]
[ground.marker.post]
axis = [0, 0, 1]
[body.block]
mass = 2
marker.up = { axis = [0, 0, 1] }
[joint.slide]
type = "prismatic"
from = "ground.post"
to = "block.up"
)toml";

// The single run in what a command printed of the mechanism `name`: JSON and nothing else.
nlohmann::json only_run(const Outcome& outcome, const std::string& kind, const std::string& name) {
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto told = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(told["kind"], kind);
  EXPECT_EQ(told["name"], name);
  EXPECT_EQ(told["runs"].size(), 1u);
  return told["runs"][0];
}

TEST_F(Flexura, ModesGivesJsonForScripts) {
  const Outcome outcome = flexura("modes --json --clamped left -n 2 -- " + beam_);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json.at("analyses").size(), 1u);
  EXPECT_EQ(json["analyses"][0]["held"], nlohmann::json({"left"}));
  EXPECT_EQ(json["analyses"][0]["n_rigid"], 0);
  ASSERT_EQ(json["analyses"][0]["modes"].size(), 2u);
  // Cantilever 0.8 m, thickness 0.03 m: 1.875104^2 sqrt(EI/(rho A)) / (2 pi L^2) = 39.16 Hz; cubic and
  // quartic terms and the rotary inertia change it by less than one percent.
  const double f = 1.875104 * 1.875104 * std::sqrt(2.1e11 * 0.03 * 0.03 / 12 / 7850) / (2 * M_PI * 0.64);
  EXPECT_NEAR(json["analyses"][0]["modes"][0]["frequency_hz"].get<double>() / f, 1.0, 0.01);
}

// What the commands on mechanisms print for people, for scripts: a spring of 1000 N/m under 2 kg and g = 10
// m/s^2.
TEST_F(Flexura, CommandsOnMechanismsGiveJsonForScripts) {
  const auto mechanism = folder_ / "spring.toml";
  std::ofstream(mechanism) << "name = \"spring\"\n"
                           << kBlockOnGuide << R"toml([force.spring]
type = "joint_spring_damper"
joint = "slide"
stiffness = 1000
[solver]
end_time = 0.1
)toml";
  const auto json = [&](const std::string& command, const std::string& kind) {
    return only_run(flexura(command + " " + mechanism.string() + " --json"), kind, "spring");
  };
  const auto modes = json("eigen --equilibrium", "natural modes");
  EXPECT_EQ(modes["coordinates"], nlohmann::json({"slide.speed"}));
  ASSERT_EQ(modes["modes"].size(), 1u);
  // sqrt(1000 / 2) / (2 pi); the stiffness is a difference quotient, 1e-6 of it.
  EXPECT_NEAR(modes["modes"][0]["frequency_hz"].get<double>(), std::sqrt(500.0) / (2 * M_PI), 1e-5);
  EXPECT_EQ(modes["modes"][0]["shape"]["real"].size(), 1u);
  const auto rest = json("statics", "equilibrium");
  bool found = false;
  for (const auto& quantity : rest["quantities"]) {
    if (quantity["name"] != "slide.position") continue;
    found = true;
    EXPECT_NEAR(quantity["value"].get<double>(), -0.02, 1e-9);  // m g / k
    EXPECT_EQ(quantity["unit"], "m");
  }
  EXPECT_TRUE(found);
  const auto start = json("assemble", "assembled");
  EXPECT_EQ(start["velocities"][0]["name"], "slide.speed");
  EXPECT_NEAR(start["velocities"][0]["acceleration"].get<double>(), -10.0, 1e-9);
  const auto linear = json("linearize --equilibrium -o " + (folder_ / "spring.m").string(), "linear system");
  EXPECT_EQ(linear["states"].size(), 2u);
  EXPECT_EQ(linear["files"], nlohmann::json({(folder_ / "spring.m").string()}));
  const auto ended = json("simulate -o " + (folder_ / "spring.h5").string(), "results");
  EXPECT_EQ(ended["complete"], true);
  EXPECT_EQ(ended["summary"]["end_time"], 0.1);
  // A file that names no runs has none to speak of.
  EXPECT_THAT(flexura("check " + mechanism.string()).out, ::testing::StartsWith("spring, t = 0 s\n"));
}

// Where controls stand: what a saved state holds of them, by the same names; a^3 + a = 10 + 0.25 is solved by 2.01909.
TEST_F(Flexura, AssembleShowsTheStatesOfControls) {
  const auto mechanism = folder_ / "controls.toml", saved = folder_ / "saved.json";
  std::ofstream(mechanism) << "name = \"controls\"\n"
                           << kBlockOnGuide << R"toml([control.lag]
type = "filter"
input = "slide.position"
time_constant = 0.1
start = 0.25
[control.root]
type = "algebraic"
equation = "root^3 + root - 10 - lag"
guess = 2
[control.held]
type = "sample"
input = "0.5 + lag"
period = 0.01
[control.open]
type = "relay"
input = "t - 1"
)toml";
  const std::string command = "assemble " + mechanism.string();
  const nlohmann::json run =
      only_run(flexura(command + " --json --save-state " + saved.string()), "assembled", "controls");
  const nlohmann::json state = nlohmann::json::parse(std::ifstream(saved));
  for (const char* const kind : {"dynamic", "algebraic"}) {
    ASSERT_EQ(run[kind].size(), state[kind].size()) << kind;
    for (const auto& one : run[kind])
      EXPECT_EQ(one["value"], state[kind][one["name"].get<std::string>()]) << one["name"];
  }
  ASSERT_EQ(run["switches"].size(), state["switches"].size());
  EXPECT_EQ(run["switches"].back()["name"], "open.level");
  EXPECT_DOUBLE_EQ(run["switches"].back()["function"], 1.0);  // off until t - 1 = 0
  for (std::size_t i = 0; i < state["switches"].size(); ++i)
    EXPECT_EQ(run["switches"][i]["value"], state["switches"][i]);
  const std::string text = flexura(command).out;
  for (const char* const shown : {"lag", "0.25", "root", "2.0190", "held", "0.75", "open", "switch"})
    EXPECT_THAT(text, ::testing::HasSubstr(shown));
}

// What a run stored, and what was computed from it afterwards: a block thrown up a guide at 3 m/s, g = 10
// m/s^2, is at 3 t - 5 t^2.
TEST_F(Flexura, ResultsAndOutputsGiveJsonForScripts) {
  const auto mechanism = folder_ / "throw.toml", results = folder_ / "throw.h5", more = folder_ / "more.h5";
  std::ofstream(mechanism) << "name = \"throw\"\n"
                           << kBlockOnGuide << R"toml(speed = 3
[output]
quantities = ["slide.position"]
[solver]
end_time = 0.6
output_step = 0.1
store_states = true
)toml";
  ASSERT_EQ(flexura("simulate " + mechanism.string() + " -o " + results.string()).code, 0);
  const auto range_of = [](const nlohmann::json& run, const std::string& name) {
    for (const auto& quantity : run["quantities"])
      if (quantity["name"] == name)
        return std::make_pair(quantity["smallest"].get<double>(), quantity["largest"].get<double>());
    ADD_FAILURE() << name << " is not in " << run.dump();
    return std::make_pair(0.0, 0.0);
  };
  const auto stored = only_run(flexura("view --summary --json " + results.string()), "results", "throw");
  EXPECT_EQ(stored["run"], "run");
  EXPECT_EQ(stored["rows"], 7);
  EXPECT_EQ(stored["complete"], true);
  EXPECT_DOUBLE_EQ(stored["time_s"].get<double>(), 0.6);
  EXPECT_GT(stored["summary"]["steps"].get<int>(), 0);
  EXPECT_EQ(stored["quantities"][0]["unit"], "m");
  // The integrator's tolerance is 1e-6; parabolas leave it far behind.
  const auto [lowest, highest] = range_of(stored, "slide.position");
  EXPECT_NEAR(lowest, 0.0, 1e-5);
  EXPECT_NEAR(highest, 0.45, 1e-5);  // at t = 0.3 s
  EXPECT_FALSE(std::filesystem::exists(folder_ / "throw.html"));

  const std::string command = "outputs " + mechanism.string() + " " + results.string() +
                              " --quantity slide.speed --csv --json -o " + more.string();
  const Outcome outcome = flexura(command);
  const auto computed = only_run(outcome, "outputs", "throw");
  const auto [slowest, fastest] = range_of(computed, "slide.speed");
  EXPECT_NEAR(slowest, -3.0, 1e-5);
  EXPECT_NEAR(fastest, 3.0, 1e-5);
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["files"],
            nlohmann::json({more.string(), (folder_ / "more.run.csv").string()}));
}

// A steel strip bent by 40 kN at its end, far beyond small rotations: F L^2 / (2 E I) = 0.54 rad.
TEST_F(Flexura, WarningsOfARunAreKeptInItsFile) {
  const auto mechanism = folder_ / "bent.toml", results = folder_ / "bent.h5";
  std::ofstream(mechanism) << R"toml([body.beam]
superelement = "beam.se.h5"
fidelity = "modal"
[joint.clamp]
type = "fixed"
from = "ground"
to = "beam.left"
[force.load]
type = "force"
marker = "beam.right"
y = 40e3
[solver]
end_time = 0.02
)toml";
  const Outcome outcome = flexura("simulate --json " + mechanism.string() + " -o " + results.string());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto warnings = nlohmann::json::parse(outcome.out)["runs"][0]["warnings"];
  ASSERT_EQ(warnings.size(), 1u) << outcome.out;
  const std::string sentence = warnings[0];
  EXPECT_THAT(sentence, HasSubstr("beam"));
  EXPECT_THAT(outcome.err, HasSubstr("warning: run: " + sentence));
  // Tables and pages read it from here.
  const auto stored = nlohmann::json::parse(flexura("view --json " + results.string()).out);
  EXPECT_EQ(stored["runs"][0]["summary"]["warnings"], warnings);
  EXPECT_THAT(flexura("view --summary " + results.string()).out, HasSubstr("warning: run: " + sentence));
}

}  // namespace
}  // namespace flexura
