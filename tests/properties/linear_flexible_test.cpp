// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// As linear_test.cpp, for bodies that bend, of every fidelity: arms on a driven cart, paths along beams, couplers of four-bars.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/properties/linear_scenes.hpp"

namespace flexura::properties {
namespace {

using mbs::chance::Chance;

// Foam, 5 Hz when clamped and 45 Hz along the axis: stiffer ones make accelerations of the error that a run leaves in positions.  Little
// damping: an ANCF beam that is led in position with 1e-3 s has T_0 of 2e5 and B of 1e10, which leave 4 digits of the motion.
const char* const kPart =
    "stiffening = true\n[material.foam]\nyoung = \"5 MPa\"\npoisson = 0.3\ndensity = \"60 kg/m^3\"\n"
    "[section.s]\ntype = \"rectangle\"\nwidth = 0.1\nheight = 0.1\n[node.root]\nposition = [0, 0, 0]\n"
    "[node.m]\nposition = [0.5, 0, 0]\n[node.tip]\nposition = [1, 0, 0]\n[member.am]\nnodes = [\"root\", "
    "\"m\"]\n[member.mb]\nnodes = [\"m\", \"tip\"]\n[interface.root]\n[interface.m]\n[interface.tip]\n"
    "[modes]\ncount = 4\n";

class FlexibleMaker : public SceneMaker {
 public:
  using SceneMaker::SceneMaker;
  Scene arm();
  Scene path();
  Scene four_bar();

 private:
  /// A beam of 1 m along x with the points root, m and tip.
  void beam(const std::string& name, const std::string& keys = "");
  /// Gravity, or none, along z; true where there is some.
  bool weight(double from, double to) {
    const bool is_heavy = chance_.flip(0.5);
    head_ = fmt::format("gravity = [0, 0, {}]\n", is_heavy ? number(from, to) : 0.0);
    return is_heavy;
  }
};

void FlexibleMaker::beam(const std::string& name, const std::string& keys) {
  static constexpr const char* kOfSuperelement[] = {"modal", "modal-stiffened", "static", "ked"};
  static constexpr const char* kOfBeam[] = {"beam", "rod", "ancf", "segments"};
  if (chance_.flip(0.6)) {
    const std::string fidelity = chance_.one_of(kOfSuperelement);
    text_ += fmt::format("[body.{}]\nsuperelement = \"beam.se.h5\"\nmodes = {}\nfidelity = \"{}\"\n{}", name,
                         1 + chance_.below(4), fidelity, keys);
    if (fidelity != "static") text_ += "damping = 0.02\n";
  } else {
    const std::string fidelity = chance_.one_of(kOfBeam);
    const bool is_planar = (fidelity == "beam" || fidelity == "rod") && chance_.flip(0.5);
    text_ += fmt::format(
        "[body.{0}]\nfidelity = \"{1}\"\n{2}[body.{0}.beam]\nto = [1, 0, 0]\nelements = 2\nyoung = \"5 "
        "MPa\"\n"
        "density = \"60 kg/m^3\"\nwidth = 0.1\nheight = 0.1\ny_axis = [0, 0, 1]\nplanar = {3}\n"
        "damping_time = 0.0001\n[body.{0}.beam.point.m]\nat = 0.5\n",
        name, fidelity, keys, is_planar);
  }
}

// An arm on a cart that is driven, bent by its weight or not.
Scene FlexibleMaker::arm() {
  const bool is_heavy = weight(-5.0, 5.0);
  text_ =
      "[ground.marker.o]\naxis = [1, 0, 0]\n[body.b0]\nmass = 1\ninertia = [0.1, 0.1, 0.1]\n"
      "[body.b0.marker.o]\naxis = [1, 0, 0]\n[body.b0.marker.p]\naxis = [0, 1, 0]\n";
  beam("beam");
  text_ += "[body.beam.marker.p]\non = \"root\"\naxis = [0, 1, 0]\n";
  joint("r", "revolute", "b0.p", "beam.p");
  joint("h", "prismatic", "ground.o", "b0.o", drive("h.position", "h.speed", "0.3*r.angle"));
  joint_force("f", "r", feedback("r.angle", "r.speed"));
  motion("h.position");
  motion("r.angle");
  place("beam.tip", "[0, 0, 1]");
  load("h", "[0, 0, 1]");
  return done(is_heavy);
}

// A mass on a beam: inputs lead or push it along, and push it across.
Scene FlexibleMaker::path() {
  static constexpr const char* kOrientations[] = {"free", "along", "fixed"};
  const bool is_heavy = weight(-5.0, 5.0), is_driven = chance_.flip(0.7);
  text_ = fmt::format(
      "[ground.marker.o]\n[body.t]\nmass = {}\ninertia = [0.01, 0.01, 0.01]\nposition = [0.5, 0, 0]\n"
      "[body.t.marker.c]\n",
      number(0.2, 2.0));
  beam("beam");
  joint("j", "fixed", "ground.o", "beam.root");
  const std::string across = input(), orientation = chance_.one_of(kOrientations);
  const std::string along = !is_driven          ? feedback("(t.x - 0.5)", "t.v_x")
                            : chance_.flip(0.5) ? led("10*m2_position", "0.3*(t.x - 0.5)")
                                                : followed();
  text_ += fmt::format(
      "[constraint.p]\ntype = \"point_on_path\"\npath = [\"beam.root\", \"beam.m\", \"beam.tip\"]\nto = "
      "\"t.c\"\norientation = \"{}\"\n",
      orientation);
  text_ += is_driven ? fmt::format("place = \"0.5 + 0.1*({})\"\n", along) : "near = 0.5\n";
  text_ += "[force.f]\ntype = \"force\"\nmarker = \"t.c\"\n";
  if (!is_driven) text_ += fmt::format("x = \"{}\"\n", along);
  text_ += fmt::format("z = \"{}\"\n", across);
  motion("p.place");
  place("t.c", "[1, 0, 0]");
  place("beam.tip", "[0, 0, 1]");
  further("p.force_z");
  load("j", "[0, 0, 1]");
  Scene scene = done(is_heavy);
  if (is_heavy) scene.u = number(-0.3, 0.3);
  return scene;
}

// A four-bar with a coupler that bends, its cranks hanging or without weight.
Scene FlexibleMaker::four_bar() {
  const bool is_heavy = weight(0.0, 5.0);
  const double crank = number(0.4, 0.8), rocker = number(0.4, 0.8), tilt = std::asin(crank - rocker);
  text_ = "[ground.marker.o]\n";
  beam("c");
  for (const auto& [name, point] : {std::pair{"l", "root"}, std::pair{"r", "tip"}})
    text_ += fmt::format("[body.c.marker.{}]\non = \"{}\"\naxis = [0, 1, 0]\n", name, point);
  const int kind = chance_.below(3);
  cranks(std::cos(tilt), crank, rocker, tilt, kind == 0 ? drive("l.angle", "l.speed", "r.angle") : "");
  if (kind == 1) joint_force("f", "r", feedback("r.angle", "r.speed"));
  if (kind == 2) coupler("lc", "r");
  motion("l.angle");
  motion("r.angle");
  further("r.speed");
  place("c.r", "[1, 0, 0]");
  load("r", "[1, 0, 0]");
  return done(is_heavy);
}

TEST(Linear, SystemsPredictTheRunsOfFlexibleMechanisms) {
  const test::Folder folder;
  const test::Outcome reduced =
      test::run("flexura", {"reduce", folder.write("beam.toml", kPart), "-q", "-o", folder / "beam.se.h5"});
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  int n_growing = 0;
  for (int seed = 1; seed <= 56; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed));
    FlexibleMaker maker(chance);
    const int kind = chance.below(3);
    const Scene scene = kind == 0 ? maker.arm() : kind == 1 ? maker.path() : maker.four_bar();
    SCOPED_TRACE(fmt::format("seed {}, u = {}\n{}{}", seed, scene.u, scene.head, scene.text));
    n_growing += expect_predicted(scene, chance, folder) ? 1 : 0;
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(n_growing, 5);
}

}  // namespace
}  // namespace flexura::properties
