// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Reactions and drive forces as accurate as the motion, and quantities by name: rigid/reaction_accuracy_*,
// rigid/quantity_energy_balance_refused, rigid/linearize_input_angle.  Closed forms over tolerances and output
// steps stand in tests/mbs/cases/reaction_accuracy.cpp and constraint_forces.cpp.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using ::testing::HasSubstr;

const std::string found = std::string(FLEXURA_SOURCE_DIR) + "/tests/found/";

double column(const results::Run& run, Eigen::Index row, const std::string& name) {
  for (std::size_t j = 0; j < run.quantities.size(); ++j)
    if (run.quantities[j].name == name) return run.values(row, static_cast<Eigen::Index>(j));
  throw std::out_of_range("no quantity " + name);
}

TEST(Reactions, OfTheDrivenSliderCrankAreRightTo1e5InAllMethods) {
  const Folder folder;
  for (const char* method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    const std::string output = folder / "run.h5";
    const Outcome simulated =
        run("flexura",
            {"simulate", found + "rigid/reaction_accuracy_driven_slider_crank.toml", "-q", "-o", output,
             "--set", fmt::format("solver.method={}", method), "--set", "solver.end_time=0.2"});
    ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
    const results::Run result = results::read(output).runs.at(0);
    ASSERT_EQ(result.time.size(), 101);
    double torque_error = 0.0, acceleration_error = 0.0, largest_torque = 0.0, largest_acceleration = 0.0;
    for (Eigen::Index i = 0; i < result.time.size(); ++i) {
      // x(f) = r cos f + sqrt(l^2 - r^2 sin^2 f), m = 2 kg, W = 50 rad/s.
      const double r = 0.1, l = 0.3, W = 50.0, f = 0.3 + W * result.time(i);
      const double root = std::sqrt(l * l - r * r * std::sin(f) * std::sin(f));
      const double root_1 = -r * r * std::sin(f) * std::cos(f) / root;
      const double root_2 = -(r * r * std::cos(2.0 * f) + root_1 * root_1) / root;
      const double a = W * W * (-r * std::cos(f) + root_2), torque = 2.0 * a * (-r * std::sin(f) + root_1);
      torque_error = std::max(torque_error, std::abs(column(result, i, "m.drive_force") - torque));
      acceleration_error = std::max(acceleration_error, std::abs(column(result, i, "s.acceleration") - a));
      largest_torque = std::max(largest_torque, std::abs(torque));
      largest_acceleration = std::max(largest_acceleration, std::abs(a));
    }
    EXPECT_NEAR(largest_torque, 34.6, 0.1);
    // 1e-9 of crank and rod beside 2 kg; asked are 1e-5.
    EXPECT_LT(torque_error, 1e-7 * largest_torque) << method;
    EXPECT_LT(acceleration_error, 1e-7 * largest_acceleration) << method;
  }
}

// Two windows (IFToMM A02) pass the position in which all rods are level: reactions grow like 1 / (t - t_0) to hundreds
// of newtons and back within milliseconds. IDA hops across with long explicit steps; rows there were those of the ends of
// these steps, 13.5 N in place of 344 N. Explicit Runge-Kutta, which solves for reactions at every stage, is what they are
// compared with: the two runs are 2e-7 s apart, 1e-3 of the least distance of a row from t_0.
TEST(Reactions, BesideAPositionThatLosesRankAreThoseOfTheState) {
  const Folder folder;
  const auto force = [&](const std::string& method) {
    const std::string output = folder / (method + ".h5");
    const Outcome simulated =
        run("flexura", {"simulate", FLEXURA_SOURCE_DIR "/cases/iftomm/a02_windows.toml", "-q",
                        "--no-estimate", "-o", output, "--set", "solver.method=" + method, "--set",
                        "solver.end_time=3.175", "--set", "solver.output_step=5e-4"});
    EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
    const results::Run result = results::read(output).runs.at(0);
    Eigen::VectorXd out(result.time.size());
    for (Eigen::Index i = 0; i < out.size(); ++i) out(i) = column(result, i, "pivot_0.force");
    return out;
  };
  const Eigen::VectorXd explicit_one = force("runge_kutta"), ida = force("ida");
  ASSERT_EQ(ida.size(), explicit_one.size());
  EXPECT_GT(explicit_one.tail(20).maxCoeff(), 300.0);
  for (Eigen::Index i = ida.size() - 20; i < ida.size(); ++i)
    EXPECT_NEAR(ida(i), explicit_one(i), 0.01 * explicit_one(i)) << i;
}

TEST(Quantities, OfTheRunMayBeNamedAndAreListed) {
  const Folder folder;
  const std::string file = found + "rigid/quantity_energy_balance_refused.toml", output = folder / "run.h5";
  const Outcome simulated =
      run("flexura", {"simulate", file, "-q", "--no-estimate", "-o", output, "--set", "solver.end_time=0.1"});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const results::Run result = results::read(output).runs.at(0);
  EXPECT_LT(std::abs(column(result, result.time.size() - 1, "energy.balance")), 1e-6);
  const Outcome listed = run("flexura", {"check", file});
  ASSERT_EQ(listed.exit_code, 0) << listed.err;
  EXPECT_THAT(listed.out, HasSubstr("balance* [J]"));
  EXPECT_THAT(listed.out, HasSubstr("rod: force*, force_x, force_y, force_z, tension* [N]"));
  const Outcome as_json = run("flexura", {"check", file, "--json"});
  const auto list = nlohmann::json::parse(as_json.out).at("runs").at(0).at("quantities");
  bool is_there = false;
  for (const auto& q : list)
    if (q.at("name") == "momentum.angular_z")
      is_there = q.at("unit") == "m^2*kg/s" && q.at("is_unique") == true;
  EXPECT_TRUE(is_there);
}

TEST(Quantities, InputsOfALinearisationGoByTheNameOfTheCoordinate) {
  const Folder folder;
  const std::string file = found + "rigid/linearize_input_angle.toml";
  std::string first;
  for (const char* input : {"shaft.angle", "shaft.speed"}) {
    const std::string output = folder / "linear.m";
    const Outcome linear = run("flexura", {"linearize", file, "--input", input, "-o", output});
    ASSERT_EQ(linear.exit_code, 0) << linear.err;
    const std::string text = read_text(output);
    if (first.empty()) first = text;
    EXPECT_EQ(text, first);
  }
  const Outcome refused = run("flexura", {"linearize", file, "--input", "shaft.angel", "-o", folder / "x.m"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("did you mean \"shaft.angle\""));
  const Outcome of_run =
      run("flexura", {"linearize", file, "--measure", "energy.balance", "-o", folder / "x.m"});
  EXPECT_EQ(of_run.exit_code, 2);
  EXPECT_THAT(of_run.err, HasSubstr("quantity of a run"));
}

// A cantilever of 0.25 m x 20 mm x 10 mm with 10 N at its tip: F L^3 / 3 E I = 149 um.
TEST(Quantities, NodesOfASurfaceHaveDisplacements) {
  const Folder folder;
  const Outcome reduced =
      run("flexura", {"reduce", found + "user/bar.toml", "-q", "-o", folder / "bar.se.h5"});
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  const std::string text = R"toml(
gravity = [0, 0, 0]
[body.bar]
superelement = "bar.se.h5"
frame = "joint_fixed"
[body.bar.surface_point.tip]
position = [0.25, 0, 0]
[joint.wall]
type = "fixed"
from = "ground"
to = "bar.a"
[force.pull]
type = "force"
marker = "bar.b"
z = "10"
[output]
quantities = ["bar.tip.*", "wall.force_z", "wall.torque_y"]
)toml";
  const auto scene = folder.write("scene.toml", text);
  const double sag = 10.0 * std::pow(0.25, 3) / (3.0 * 210e9 * 0.02 * std::pow(0.01, 3) / 12.0);
  const auto quantities = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"statics", scene.string(), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome rest = run("flexura", arguments);
    EXPECT_EQ(rest.exit_code, 0) << rest.err;
    std::map<std::string, double> values;
    const auto parsed = nlohmann::json::parse(rest.out);
    for (const auto& q : parsed.at("runs").at(0).at("quantities"))
      values[q.at("name").get<std::string>()] = q.at("value").get<double>();
    return values;
  };
  auto values = quantities({});
  // Shear adds (h/L)^2 of it.
  EXPECT_NEAR(values.at("bar.tip.displacement_z"), sag, 0.01 * sag);
  EXPECT_NEAR(values.at("bar.tip.displacement"), sag, 0.02 * sag);
  const double corner = values.at("bar.tip.position_z") - values.at("bar.tip.displacement_z");
  EXPECT_LE(std::abs(corner), 0.005 + 1e-9);  // a node of the section's outline
  EXPECT_NEAR(values.at("wall.force_z"), -10.0, 1e-6);
  EXPECT_NEAR(values.at("wall.torque_y"), 2.5, 1e-3);
  // As a rigid body its node stands still in it.
  values = quantities({"--set", "body.bar.fidelity=rigid"});
  EXPECT_EQ(values.at("bar.tip.displacement"), 0.0);
  EXPECT_NEAR(values.at("bar.tip.position_z"), corner, 1e-12);
}

}  // namespace
}  // namespace flexura::test
