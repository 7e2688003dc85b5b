// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Linear systems about states that are as good as equilibria or steady motions.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <random>

#include "mbs/base/hdf5/file.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

class BesideEquilibrium : public ::testing::Test {
 protected:
  nlohmann::json eigen(const std::string& file, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"eigen", file, "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run("flexura", words);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out)["runs"][0];
  }
  Folder folder_;
};

// The first N were those that do not vibrate, however fast they decay: a damper of 1e5 1/s before the vibrations at 1 Hz that were
// asked for.  Masses on springs and dampers of their own have s^2 + 2 zeta w s + w^2 = 0.
TEST_F(BesideEquilibrium, TheFirstModesAreTheSlowest) {
  std::mt19937 random(20261128);
  const auto draw = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  for (int i = 0; i < 20; ++i) {
    constexpr int kMasses = 6;
    std::vector<std::complex<double>> wanted;
    std::string text = "gravity = [0, 0, 0]\n";
    for (int k = 0; k < kMasses; ++k) {
      const double w = std::pow(10.0, draw(0.0, 3.0)),
                   zeta = random() % 2 == 0 ? draw(0.0, 0.9) : std::pow(10.0, draw(0.1, 2.0));
      text += fmt::format(
          "[body.b{0}]\nmass = 1\n[joint.j{0}]\ntype = \"prismatic\"\nfrom = \"ground\"\nto = \"b{0}\"\n"
          "[force.s{0}]\ntype = \"joint_spring_damper\"\njoint = \"j{0}\"\nstiffness = {1}\ndamping = {2}\n",
          k, w * w, 2.0 * zeta * w);
      const std::complex<double> root = std::sqrt(std::complex<double>(zeta * zeta - 1.0, 0.0));
      wanted.push_back(w * (-zeta + root));
      if (zeta > 1.0) wanted.push_back(-w / (zeta + root));
      if (zeta > 1.0) wanted[wanted.size() - 2] = -w * (zeta + root);
    }
    std::ranges::sort(wanted, {}, [](const std::complex<double>& s) { return std::abs(s); });
    const int count = 1 + static_cast<int>(random() % wanted.size());
    const nlohmann::json modes =
        eigen(folder_.write("m.toml", text), {"--count", std::to_string(count)})["modes"];
    ASSERT_EQ(modes.size(), static_cast<std::size_t>(count)) << text;
    for (int k = 0; k < count; ++k) {
      const std::complex<double> found(modes[k]["real_1_s"].get<double>(),
                                       modes[k]["imag_1_s"].get<double>()),
          exact = wanted[static_cast<std::size_t>(k)];
      // Round-off of a matrix whose eigenvalues are 1e-2 to 1e5.
      EXPECT_LT(std::abs(found - exact), 1e-6 * std::abs(exact) + 1e-8) << k << "\n" << text;
    }
  }
}

const char* const kSoftPart = R"(
[material.s]
young = 2e9
poisson = 0.3
density = 1200
[section.a]
type = "rectangle"
width = 0.005
height = 0.005
[node.a]
position = [0, 0, 0]
[node.b]
position = [0.5, 0, 0]
[node.c]
position = [0.5, 0.5, 0.2]
[member.m]
nodes = ["a", "b"]
[member.n]
nodes = ["b", "c"]
[interface.a]
[interface.b]
[mass.q]
node = "c"
mass = 30
[modes]
count = 10
damping = 0
)";

// Loads so small that the state beside the equilibrium counted as it stood in the stiffness by their lever to the heavy mass: 54 % of
// growth under a load that moves the part by 7 micrometres.  The part is linear: its frequencies are those without a load, but for
// how far the load turns it, 1e-4 at most.
TEST_F(BesideEquilibrium, SmallLoadsLeaveTheFrequenciesOfASoftPart) {
  ASSERT_EQ(
      run("flexura", {"reduce", folder_.write("part.toml", kSoftPart), "-q", "-o", folder_ / "part.se.h5"})
          .exit_code,
      0);
  const std::string scene =
      "gravity = [0, 0, 0]\n[body.p]\nsuperelement = \"part.se.h5\"\n"
      "[joint.j]\ntype = \"fixed\"\nfrom = \"ground\"\nto = \"p.a\"\n";
  const auto modes = [&](double load, const std::string& key) {
    const std::string file = folder_.write(
        "load.toml",
        scene + fmt::format("[force.F]\ntype = \"force\"\nmarker = \"p.b\"\nx = {}\ny = {}\nz = {}\n",
                            0.7 * load, 0.3 * load, 0.5 * load));
    return eigen(file, {"--set", key})["modes"];
  };
  for (const std::string key : {"body.p.frame=mean_axis", "body.p.frame=joint_fixed"}) {
    const nlohmann::json unloaded = modes(0.0, key);
    ASSERT_GE(unloaded.size(), 8u);
    for (double load = 1e-8; load < 3e-4; load *= 2.7) {
      const nlohmann::json loaded = modes(load, key);
      ASSERT_EQ(loaded.size(), unloaded.size());
      for (std::size_t k = 0; k < 8; ++k) {
        const double right = unloaded[k]["imag_1_s"];
        EXPECT_NEAR(loaded[k]["imag_1_s"].get<double>(), right, 1e-4 * right)
            << key << " " << load << " N, mode " << k;
        EXPECT_EQ(loaded[k]["real_1_s"].get<double>(), 0.0) << key << " " << load << " N, mode " << k;
      }
    }
  }
}

const char* const kRotor = R"(
gravity = [0, 0, 0]
[body.hub]
mass = 2
inertia = [0.4, 0.4, 0.45]
[body.hub.marker.s]
position = [-0.28, 0.04, 0]
axis = [-0.14, -0.99, 0]
[body.m]
mass = 0.3
inertia = [0.01, 0.011, 0.012]
center = [0, 0, -0.2]
[body.m.marker.o]
axis = [-0.14, -0.99, 0]
[joint.h]
type = "revolute"
from = "ground"
to = "hub"
speed = 25
[joint.j]
type = "revolute"
from = "hub.s"
to = "m.o"
[force.f]
type = "joint_spring_damper"
joint = "j"
stiffness = 8
damping = 0.3
[output]
quantities = ["h.torque_z"]
y = ["h.speed", "h.torque_z", "h.force", "h.acceleration", "j.angle"]
[solver]
tolerance = 1e-10
end_time = 20
output_step = 1
)";

// "The coefficients change along the motion by 57 %": those of the torque about its own axis that a free hinge transmits, 1e-11.
TEST_F(BesideEquilibrium, WhatAFreeHingeDoesNotTransmitIsNoChangeOfASteadyMotion) {
  const std::string file = folder_.write("rotor.toml", kRotor);
  ASSERT_EQ(run("flexura",
                {"simulate", file, "-q", "-o", folder_ / "rotor.h5", "--save-state", folder_ / "end.json"})
                .exit_code,
            0);
  const Outcome outcome =
      run("flexura", {"linearize", file, "--from-state", folder_ / "end.json", "-o", folder_ / "rotor.m"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

// A body of alike moments of inertia that spins on a turning hub: a pair of 2e-7 1/s, of which one grows, for two zeros.
TEST_F(BesideEquilibrium, FreeSpinsDoNotGrow) {
  const std::string file = folder_.write("spin.toml", R"(
gravity = [0,0,0]
[ground.marker.o]
axis = [0,0,1]
[input.b]
value = "0"
[input.a]
value = "0"
[body.hub]
mass = 2.0
inertia = [0.4,0.4,0.45]
[body.hub.marker.o]
axis = [0,0,1]
[body.hub.marker.s0]
position = [0.1504489968164934,-0.2458274043276156,0.0]
axis = [0.5220085452533794,-0.8529402550486467,0.0]
[body.m0]
mass = 0.381
inertia = [0.02,0.02,0.02]
center = [0,0,0]
[body.m0.marker.o]
axis = [0.5220085452533794,-0.8529402550486467,0.0]
[joint.jh]
type = "revolute"
from = "ground.o"
to = "hub.o"
drive_speed = "24.031+a"
[joint.j0]
type = "revolute"
from = "hub.s0"
to = "m0.o"
speed = 8.681888767390326
)");
  const nlohmann::json modes = eigen(file)["modes"];
  EXPECT_EQ(modes.size(), 2u);
  for (const auto& mode : modes) {
    EXPECT_EQ(mode["real_1_s"].get<double>(), 0.0);
    EXPECT_EQ(mode["imag_1_s"].get<double>(), 0.0);
  }
}

// Datasets A, B and C of a system without states were missing.
TEST_F(BesideEquilibrium, ASystemWithoutStatesHasAllItsMatrices) {
  const std::string file = folder_.write("driven.toml", R"(
[input.u]
value = "0"
[body.b]
mass = 1
inertia = [1, 1, 1]
[joint.j]
type = "prismatic"
from = "ground"
to = "b"
drive = "u"
[output]
quantities = ["b.position_z"]
y = ["b.position_z"]
)");
  const Outcome outcome = run("flexura", {"linearize", file, "-o", folder_ / "driven.h5"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const hdf5::File h5(folder_ / "driven.h5", hdf5::Mode::read);
  for (const auto& [name, rows, columns] : {std::tuple{"A", 0, 0}, {"B", 0, 1}, {"C", 1, 0}, {"D", 1, 1}})
    EXPECT_NO_THROW(hdf5::read_matrix(h5.root(), name, rows, columns)) << name;
}

}  // namespace
}  // namespace flexura::test
