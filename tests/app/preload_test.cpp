// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Preloads of a body itself, from part files to frequencies, buckling and motion.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using std::numbers::pi;
using testing::AllOf;
using testing::HasSubstr;

// Steel, 10 mm round, 1 m long.
constexpr double kYoung = 2.1e11, kDensity = 7850.0, kDiameter = 0.01;
const double kArea = pi / 4 * kDiameter * kDiameter, kI = pi / 64 * std::pow(kDiameter, 4),
             kEuler = pi * pi * kYoung * kI;

// S. P. Timoshenko, Vibration Problems in Engineering, art. 63: between pins under the tension P [Hz].
double pinned_hz(int n, double P) {
  return n * n * pi / 2 * std::sqrt(kYoung * kI / (kDensity * kArea)) * std::sqrt(1 + P / (n * n * kEuler));
}

const std::string kWire = R"toml(
stiffening = true
[material.steel]
young = "210 GPa"
poisson = 0.3
density = 7850
[section.round]
type = "circle"
diameter = "10 mm"
[node.left]
position = [0, 0, 0]
[node.right]
position = [1, 0, 0]
[member.wire]
nodes = ["left", "right"]
section = "round"
theory = "euler_bernoulli"
elements = 16
[interface.left]
[interface.right]
[load.tension]
member = "wire"
preload = "1 N"
[modes]
count = 16
)toml";

const std::string kBetweenPins = R"toml(
gravity = [0, 0, 0]
[ground.marker.left]
axis = [0, 1, 0]
[ground.marker.right]
position = [1, 0, 0]
axis = [0, 1, 0]
[body.wire]
superelement = "wire.se.h5"
fidelity = "modal-stiffened"
damping = 0
[body.wire.marker.l]
on = "left"
axis = [0, 1, 0]
[body.wire.marker.r]
on = "right"
axis = [0, 1, 0]
[body.wire.section_point.middle]
position = [0.5, 0, 0]
[joint.left]
type = "revolute"
from = "ground.left"
to = "wire.l"
[joint.right]
type = "revolute"
from = "ground.right"
to = "wire.r"
[force.tension]
type = "distributed_load"
body = "wire"
load = "tension"
factor = 1
[output]
quantities = ["*"]
[solver]
end_time = 0.01
initial_deformation = "quasi_static"
)toml";

class Preloads : public testing::Test {
 protected:
  void reduce(const std::string& part, const std::string& text, const std::string& to) {
    const Outcome outcome = run("flexura", {"reduce", folder_.write(part, text), "-q", "-o", folder_ / to});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  std::string refusal(const std::string& name, const std::string& text) {
    const Outcome outcome =
        run("flexura", {"reduce", folder_.write(name, text), "-q", "-o", folder_ / "none.se.h5"});
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    return outcome.err;
  }
  nlohmann::json eigen(const std::filesystem::path& file, std::vector<std::string> options) {
    options.insert(options.begin(), {"eigen", file, "--json"});
    const Outcome outcome = run("flexura", options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.exit_code == 0 ? nlohmann::json::parse(outcome.out)["runs"][0] : nlohmann::json();
  }
  // The frequency that lies nearest to the one wanted.
  static double nearest(const nlohmann::json& run, double hz) {
    double best = 0.0;
    for (const auto& mode : run["modes"])
      if (const double f = mode["frequency_hz"]; std::abs(f - hz) < std::abs(best - hz)) best = f;
    return best;
  }
  // Rows of a quantity of a run.
  Eigen::VectorXd simulate(const std::filesystem::path& file, const std::string& quantity,
                           const std::vector<std::string>& set = {}) {
    const std::string output = folder_ / "run.h5";
    std::vector<std::string> arguments = {"simulate", file, "-q", "--no-estimate", "-o", output};
    for (const std::string& one : set) arguments.insert(arguments.end(), {"--set", one});
    const Outcome outcome = run("flexura", arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const results::Results results = results::read(output);
    for (std::size_t j = 0; j < results.runs.at(0).quantities.size(); ++j)
      if (results.runs[0].quantities[j].name == quantity)
        return results.runs[0].values.col(static_cast<Eigen::Index>(j));
    throw std::logic_error(quantity + " is not in the results");
  }
  Folder folder_;
};

// Both ends are held: all of the tension stays, by the forces of the joints.
TEST_F(Preloads, TuneAWireBetweenPins) {
  reduce("wire.part.toml", kWire, "wire.se.h5");
  const auto file = folder_.write("wire.toml", kBetweenPins);
  for (const double P : {0.0, 3.0 * kEuler, -0.5 * kEuler}) {
    const nlohmann::json run =
        eigen(file, {"--equilibrium", "--count", "12", "--set", fmt::format("force.tension.factor={}", P)});
    for (const int n : {1, 2, 3}) {
      // Rotary inertia: (n pi d / 8)^2 = 4e-5 n^2 of the formula, whose half is the frequency's share.
      const double exact = pinned_hz(n, P) * (1 - 0.5 * std::pow(n * pi * kDiameter / 4, 2));
      EXPECT_NEAR(nearest(run, exact), exact, 3e-5 * n * n * exact) << P << " N, mode " << n;
    }
  }
  const nlohmann::json buckling = eigen(file, {"--buckling", "--set", "force.tension.factor=-100"});
  EXPECT_NEAR(buckling["modes"][0]["load_factor"].get<double>(), kEuler / 100, 1e-5 * kEuler / 100);
  const Eigen::VectorXd N = simulate(file, "wire.middle.N", {"force.tension.factor=1000"});
  EXPECT_NEAR(N(0), 1000.0, 1e-6);
}

// A rod hinged into a stiff tube, free in space.  Tube and rod share the tension as springs do.
TEST_F(Preloads, HoldThemselvesInBalance) {
  const std::string tube = replaced(kWire, "[interface.right]\n", "") + R"toml(
[section.tube]
type = "hollow_circle"
outer_diameter = "300 mm"
inner_diameter = "290 mm"
[member.tube]
nodes = ["left", "right"]
section = "tube"
theory = "euler_bernoulli"
elements = 6
)toml";
  reduce("tube.part.toml",
         replaced(tube, "elements = 16\n",
                  "elements = 16\nrelease_1 = [\"ry\", \"rz\"]\nrelease_2 = [\"ry\", \"rz\"]\n"),
         "wire.se.h5");
  const auto file = folder_.write("tube.toml", R"toml(
gravity = [0, 0, 0]
[body.wire]
superelement = "wire.se.h5"
fidelity = "modal-stiffened"
damping = 0
[body.wire.section_point.rod]
member = "wire"
share = 0.5
[force.tension]
type = "distributed_load"
body = "wire"
load = "tension"
factor = "2000 * step(t, 0, 0, 0.005, 1)"
[output]
quantities = ["*"]
[solver]
end_time = 0.02
)toml");
  const double tube_area = pi / 4 * (0.3 * 0.3 - 0.29 * 0.29), share = tube_area / (tube_area + kArea);
  const nlohmann::json run =
      eigen(file, {"--equilibrium", "--count", "30", "--set", "force.tension.factor=2000"});
  for (const int n : {1, 2}) {
    // The body answers the rod's motion by its own: its first mode carries 8 / pi^2 of its mass along, the second 1 / (2 pi^2) of
    // its mass times the square of its length as inertia.
    const double rod = kArea, whole = tube_area + kArea,
                 turned = tube_area * (3 * (0.15 * 0.15 + 0.145 * 0.145) + 1) / 12 + rod / 12,
                 carried = n == 1 ? 8 / (pi * pi) * rod / whole : rod / (2 * pi * pi) / turned;
    const double exact =
        pinned_hz(n, 2000 * share) * (1 - 0.5 * std::pow(n * pi * kDiameter / 4, 2)) / std::sqrt(1 - carried);
    // The tube bends at 1.9 kHz, 20 and more times the rod's frequencies: some 1e-5 of that answer.
    EXPECT_NEAR(nearest(run, exact), exact, 1e-4 * exact) << n;
  }
  for (const char* part : {"linear_x", "linear_y", "linear_z", "angular_x", "angular_y", "angular_z"})
    EXPECT_LT(simulate(file, std::string("momentum.") + part).cwiseAbs().maxCoeff(), 1e-9) << part;
}

// Bricks of 5 mm on a bar of 0.4 m x 10 mm x 10 mm.
std::string bar_deck() {
  constexpr int nx = 80, ny = 2, nz = 2;
  const auto id = [&](int i, int j, int k) { return 1 + i + (nx + 1) * (j + (ny + 1) * k); };
  std::string deck = "*NODE\n", cells = "*ELEMENT, TYPE=C3D8I, ELSET=E\n", root = "*NSET, NSET=ROOT\n",
              tip = "*NSET, NSET=TIP\n";
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        deck += fmt::format("{}, {}, {}, {}\n", id(i, j, k), 0.005 * i, 0.005 * j - 0.005, 0.005 * k - 0.005);
  int n = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        cells += fmt::format("{}, {}, {}, {}, {}, {}, {}, {}, {}\n", ++n, id(i, j, k), id(i + 1, j, k),
                             id(i + 1, j + 1, k), id(i, j + 1, k), id(i, j, k + 1), id(i + 1, j, k + 1),
                             id(i + 1, j + 1, k + 1), id(i, j + 1, k + 1));
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j) {
      root += fmt::format("{}\n", id(0, j, k));
      tip += fmt::format("{}\n", id(nx, j, k));
    }
  return deck + cells + root + tip +
         "*SOLID SECTION, ELSET=E, MATERIAL=M\n*MATERIAL, NAME=M\n*DENSITY\n7850.\n*ELASTIC\n2.1e11, 0.3\n";
}

const std::string kBar = R"toml(
stiffening = true
[geometry]
file = "bar.inp"
[interface.root]
by = "group"
group = "ROOT"
[interface.tip]
by = "group"
group = "TIP"
[load.preload]
type = "preload"
strain = "-1e-3"
axis = [1, 0, 0]
[modes]
count = 12
certify = false
[recovery]
stress = true
precision = "double"
)toml";

const std::string kClampedBar = R"toml(
gravity = [0, 0, 0]
[ground.marker.tip]
position = [0.4, 0, 0]
[body.bar]
superelement = "bar.se.h5"
fidelity = "modal-stiffened"
damping = 0
[body.bar.stress_point.middle]
position = [0.2, 0.005, 0]
[joint.root]
type = "fixed"
from = "ground"
to = "bar.root"
[joint.tip]
type = "fixed"
from = "ground.tip"
to = "bar.tip"
[force.preload]
type = "distributed_load"
body = "bar"
load = "preload"
factor = 1
[output]
quantities = ["*"]
[solver]
end_time = 0.001
initial_deformation = "quasi_static"
)toml";

// First eigenvalue omega^2 of a clamped beam of length 1, EI = m = 1, under the tension T: the characteristic equation,
// 2 T l + ... of the shapes cosh, sinh, cos, sin with a^2 - b^2 = T, a b = omega.
double clamped_omega(double T) {
  const auto f = [T](double omega) {
    const double root = std::sqrt(0.25 * T * T + omega * omega), a = std::sqrt(root + 0.5 * T),
                 b = std::sqrt(root - 0.5 * T);
    return 2 * a * b * (1 - std::cosh(a) * std::cos(b)) + (a * a - b * b) * std::sinh(a) * std::sin(b);
  };
  double low = 5.0, high = 1.0;
  for (high = low; f(low) * f(high) > 0; high += 0.05) low = high;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (f(low) * f(middle) > 0 ? low : high) = middle;
  }
  return low;
}

TEST_F(Preloads, StiffenABarBetweenWalls) {
  folder_.write("bar.inp", bar_deck());
  reduce("bar.part.toml", kBar, "bar.se.h5");
  const auto file = folder_.write("bar.toml", kClampedBar);
  // T L^2 / EI = 12 * 1e-3 * (L/h)^2 = 19.2 at factor 1.
  const auto first = [&](double factor) {
    return eigen(file, {"--equilibrium", "--count", "3", "--set",
                        fmt::format("force.preload.factor={}", factor)})["modes"][0]["frequency_hz"]
        .get<double>();
  };
  const double at_rest = first(0.0);
  // Timoshenko's 1921 frequency is 0.8 % lower by shear, which tension changes by a share of it; bricks of 5 mm as well.
  EXPECT_NEAR(at_rest, 22.3733 / (2 * pi) * 0.01 / 0.16 * std::sqrt(kYoung / (12 * kDensity)),
              0.015 * at_rest);
  for (const double factor : {1.0, 3.0, -1.0})
    EXPECT_NEAR(first(factor) / at_rest, clamped_omega(19.2 * factor) / clamped_omega(0.0), 3e-3) << factor;
  // Clamped ends: P = 4 pi^2 EI / L^2, less the shear's share P / (G A 5/6) = 4e-3 (Engesser).
  const nlohmann::json buckling = eigen(file, {"--buckling", "--set", "force.preload.factor=-1"});
  EXPECT_NEAR(buckling["modes"][0]["load_factor"].get<double>(), 4 * pi * pi / 19.2,
              0.01 * 4 * pi * pi / 19.2);
  // The rigid walls hold the sides of the bar as well, which makes it stiffer over a thickness or so: 1 / 40 of its length, nu^2.
  EXPECT_NEAR(simulate(file, "bar.middle.stress_xx")(0), 210e6, 0.09 / 40 * 2 * 210e6);
}

// Heat that finds no resistance: longer by it, and without stress.
TEST_F(Preloads, OfFreeHeatStressNothing) {
  folder_.write("bar.inp", bar_deck());
  std::string part = replaced(replaced(kBar, "strain = \"-1e-3\"\naxis = [1, 0, 0]\n", "strain = 5e-4\n"),
                              "group = \"ROOT\"\n", "group = \"ROOT\"\ntie = \"average\"\n");
  part = replaced(part, "group = \"TIP\"\n", "group = \"TIP\"\ntie = \"average\"\n");
  reduce("bar.part.toml", part, "bar.se.h5");
  const std::string text =
      replaced(kClampedBar, "[joint.tip]\ntype = \"fixed\"\nfrom = \"ground.tip\"\nto = \"bar.tip\"\n", "") +
      "[measure.length]\ntype = \"position\"\nfrom = \"bar.root\"\nto = \"bar.tip\"\ndirection = [1, 0, 0]\n";
  const auto file = folder_.write("bar.toml", text);
  // Strains of modal-stiffened bodies are Green's: e + e^2 / 2 = 5e-4.
  EXPECT_NEAR(simulate(file, "length")(0), 0.4 * std::sqrt(1 + 2 * 5e-4), 1e-9 * 0.4);
  EXPECT_LT(simulate(file, "bar.middle.von_mises")(0), 1e-6 * kYoung * 5e-4);
}

// Walls that leave the sides free: the stress is uniaxial all along.
TEST_F(Preloads, StressABarBetweenSmoothWalls) {
  folder_.write("bar.inp", bar_deck());
  std::string part =
      replaced(kBar, "group = \"ROOT\"\n", "group = \"ROOT\"\ntie = \"average\"\nweights = \"area\"\n");
  part = replaced(part, "group = \"TIP\"\n", "group = \"TIP\"\ntie = \"average\"\nweights = \"area\"\n");
  reduce("bar.part.toml", part, "bar.se.h5");
  const auto file = folder_.write("bar.toml", kClampedBar);
  EXPECT_NEAR(simulate(file, "bar.middle.stress_xx")(0), 210e6, 1e-6 * 210e6);
  EXPECT_NEAR(simulate(file, "bar.middle.von_mises")(0), 210e6, 1e-6 * 210e6);
  // Elastic strain alone: the bar is as long as before.
  EXPECT_NEAR(simulate(file, "bar.middle.strain_xx")(0), 1e-3, 1e-9);
  EXPECT_NEAR(simulate(file, "tip.force_x")(0), 210e6 * 1e-4, 1e-6 * 210e6 * 1e-4);
}

TEST_F(Preloads, AreRefusedWithTheReason) {
  folder_.write("bar.inp", bar_deck());
  EXPECT_THAT(refusal("a.toml", replaced(kBar, "\"-1e-3\"", "\"x > 1 ? -1e-3 : 0\"")),
              AllOf(HasSubstr("load.preload"), HasSubstr("zero in the middle of every element")));
  EXPECT_THAT(refusal("b.toml", replaced(kBar, "\"-1e-3\"", "\"20\"")),
              HasSubstr("give a length over a length"));
  EXPECT_THAT(refusal("c.toml", replaced(kBar, "axis = [1, 0, 0]\n", "axis = [1, 0, 0]\nmaterial = \"N\"\n")),
              HasSubstr("there is no material \"N\"; known are M"));
  EXPECT_THAT(refusal("d.toml", replaced(kWire, "member = \"wire\"\npreload", "node = \"left\"\npreload")),
              AllOf(HasSubstr("preload"), HasSubstr("is for members")));
  EXPECT_THAT(refusal("e.toml", replaced(kWire, "elements = 16\n", "elements = 16\nrelease_1 = [\"x\"]\n")),
              AllOf(HasSubstr("load.tension.preload"), HasSubstr("slides along it")));
}

}  // namespace
}  // namespace flexura::test
