// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/solver/statics/equilibrium.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"
#include "tests/mbs/test_folder.hpp"

/// ANCF beams of mechanism files: what they are solved with, and where they come to rest.
namespace flexura::mbs {
namespace {

constexpr double kEI = 175.0;  ///< of the beam below

std::string steel_beam(const std::string& name, double from, int elements) {
  return "[body." + name + "]\nfidelity = \"ancf\"\nposition = [" + std::to_string(from) + ", 0, 0]\n[body." +
         name + ".beam]\nto = [1, 0, 0]\nelements = " + std::to_string(elements) +
         R"toml(
young = "210 GPa"
density = "7850 kg/m^3"
width = "10 mm"
height = "10 mm"
)toml";
}

std::string joint(const std::string& from, const std::string& to) {
  return "[joint." + to + "]\ntype = \"fixed\"\nfrom = \"" + from + "\"\nto = \"" + to + ".root\"\n";
}

std::string measures(const std::string& of) {
  const std::string place = "type = \"position\"\nfrom = \"ground\"\nto = \"" + of + "\"\ndirection = ";
  return "[measure.x]\n" + place + "[1, 0, 0]\n[measure.z]\n" + place + "[0, 0, 1]\n";
}

class AncfFile : public test::TestFolder {
 protected:
  /// The measures x and z in static equilibrium.
  Eigen::Vector2d rest(const std::string& text) const {
    PreparedMechanism p = prepare(file(text));
    find_equilibrium(*p.mechanism, p.state);
    const std::vector<int> which = select_quantities(*p.mechanism, {"x", "z"});
    Eigen::VectorXd out(which.size());
    p.mechanism->evaluate(which, p.state, Eigen::VectorXd::Zero(p.state.v.size()),
                          *p.mechanism->make_scratch(), out);
    return out;
  }
};

TEST_F(AncfFile, IsSolvedByRadauUnlessTold) {
  const std::string text = steel_beam("a", 0.0, 2) + joint("ground", "a");
  EXPECT_EQ(prepare(file(text)).options.method, "radau");
  EXPECT_EQ(prepare(file(text + "[solver]\nmethod = \"ida\"\n")).options.method, "ida");
  EXPECT_EQ(prepare(file(text), {"body.a.fidelity=segments"}).options.method, "ida");
}

// A cantilever of two halves, 2 m under its weight: q L^4 / 8 EI = 88 mm.  It bends by 0.058 rad, which makes
// it less by about its square; halves of 4 elements of constant curvature by (h/L)^2 = 1/64 / 2: 1 % in all.
TEST_F(AncfFile, HalvesOfACantileverHangAsItDoesWhole) {
  const double q = 7850.0 * 1e-4 * 9.81, exact = q * 16.0 / (8.0 * kEI);
  const std::string weight = "gravity = [0, 0, -9.81]\n",
                    a = steel_beam("a", 1.0, 4) + joint("b.tip", "a") + measures("a.tip"),
                    b = joint("ground", "b");
  EXPECT_NEAR(-rest(weight + steel_beam("b", 0.0, 4) + b + a).y(), exact, 0.01 * exact);
  beams::StraightBeam half;
  half.EA = 2.1e7;
  half.EI_y = half.EI_z = kEI;
  half.GI_t = 114.0;
  half.mass_per_length = 0.785;
  half.rho_I_y = half.rho_I_z = 7850.0 * 1e-8 / 12.0;
  superelement::write(folder_ / "half.se.h5", beams::beam_superelement(half));
  EXPECT_NEAR(-rest(weight + "[body.b]\nsuperelement = \"half.se.h5\"\n" + b + a).y(), exact, 0.01 * exact);
}

// An end moment of EI/L times an angle rolls it up to a circle's arc of it: 3 rad by Newton's method, 5 rad
// where the moment grows by steps.
TEST_F(AncfFile, CantileverIsRolledUpByAMomentAtItsTip) {
  const auto error = [&](double angle, int elements) -> Eigen::Vector2d {
    const Eigen::Vector2d exact(std::sin(angle) / angle, (1.0 - std::cos(angle)) / angle);
    return rest("gravity = [0, 0, 0]\n" + steel_beam("a", 0.0, elements) + joint("ground", "a") +
                "[force.f]\ntype = \"torque\"\nmarker = \"a.tip\"\ny = \"-175*" + std::to_string(angle) +
                "\"\n" + measures("a.tip")) -
           exact;
  };
  // The error is of order 2 in the angle a of an element; without it some 3 a^4 are left, 4e-3.
  const Eigen::Vector2d coarse = error(3.0, 8), fine = error(3.0, 16);
  EXPECT_LT(fine.norm(), 0.3 * coarse.norm());
  EXPECT_LT(((4.0 * fine - coarse) / 3.0).norm(), 4e-3);
  // As much of 5 rad at the same order; the tip moves less by the angle there.
  const double a_3 = 3.0 / 8.0, a_5 = 5.0 / 12.0;
  EXPECT_LT(error(5.0, 12).norm(), coarse.norm() * (5.0 * a_5 * a_5) / (3.0 * a_3 * a_3));
}

// A cable of 1 m between hinges 0.8 m apart: a sinh(0.4/a) = 0.5, sag a (cosh(0.4/a) - 1).  The hinges close
// by bending it, not by crushing it.
TEST_F(AncfFile, CableBetweenHingesHangsAsACatenary) {
  const double a = 0.338201879085335, sag = a * (std::cosh(0.4 / a) - 1.0);
  const Eigen::Vector2d at = rest(R"toml(
gravity = [0, 0, -9.81]
[body.cable]
fidelity = "ancf"
[body.cable.beam]
to = [1, 0, 0]
elements = 8
EA = 1e6
EI_y = 1e-3
EI_z = 1e-3
GI_t = 1e-3
GA_y = 1e5
GA_z = 1e5
mass_per_length = 0.1
rho_I_y = 1e-8
rho_I_z = 1e-8
point.middle.at = 0.5
[body.cable.marker.r]
on = "root"
axis = [0, 1, 0]
[body.cable.marker.t]
on = "tip"
axis = [0, 1, 0]
[ground.marker.a]
axis = [0, 1, 0]
[ground.marker.b]
position = [0.8, 0, 0]
axis = [0, 1, 0]
[joint.a]
type = "revolute"
from = "ground.a"
to = "cable.r"
[joint.b]
type = "revolute"
from = "ground.b"
to = "cable.t"
)toml" + measures("cable.middle"));
  EXPECT_NEAR(at.x(), 0.4, 1e-6);  // symmetric
  // The catenary has the least energy, so that bending, which stores 1.3 % of it, changes the sag by less;
  // found folded it sagged by 13 % less.
  EXPECT_NEAR(-at.y(), sag, 0.01 * sag);
}

}  // namespace
}  // namespace flexura::mbs
