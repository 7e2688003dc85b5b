// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Materials with directions: cylindrical axes of solids, directions of shells, layers.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "tests/found/decks/plate_deck.hpp"
#include "tests/found/parts.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

class DeckDirections : public Parts {
 public:
  Reduced reduce_inp(const std::string& deck, const std::string& rest) {
    return reduce_deck(deck, "unit = \"m\"\n" + rest, {}, "deck.inp");
  }
};

// A ring of bricks under equal stretch of its bore's radius: with E_r = E_t = E_z and the like nothing depends on the axes; with
// wood whose fibres run around, turning the part by any angle about its axis changes nothing, which rectangular axes would.
// The same ring, whose nodes and elements start 30 degrees further on, has the same frequencies.
TEST_F(DeckDirections, FibresThatRunAroundAreTheSameFromEverywhere) {
  const auto ring = [](double start, const std::string& orientation) {
    constexpr int n = 12;
    std::string text = "*NODE\n";
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < 4; ++k) {
        const double a = start + 2 * std::numbers::pi * i / n, r = k % 2 ? 0.13 : 0.1;
        text += fmt::format("{}, {:.15g}, {:.15g}, {}\n", 4 * i + k + 1, r * std::cos(a), r * std::sin(a),
                            k < 2 ? 0.0 : 0.02);
      }
    text += "*ELEMENT, TYPE=C3D8, ELSET=E\n";
    for (int i = 0; i < n; ++i) {
      const int a = 4 * i + 1, b = 4 * ((i + 1) % n) + 1;
      text += fmt::format("{}, {},{},{},{}, {},{},{},{}\n", i + 1, a, a + 1, b + 1, b, a + 2, a + 3, b + 3,
                          b + 2);
    }
    return text + orientation +
           "*SOLID SECTION, ELSET=E, MATERIAL=W, ORIENTATION=O\n*MATERIAL, NAME=W\n*ELASTIC, "
           "TYPE=ENGINEERING CONSTANTS\n"
           "1.E9, 1.E10, 2.E9, .03, .1, .2, 5.E8, 9.E8\n7.E8\n*DENSITY\n500.\n";
  };
  const auto hz = [&](const std::string& deck) {
    const Reduced r = reduce_inp(deck, "[modes]\ncount = 6\n");
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    return r.se.omega2;
  };
  const std::string cylinder = "*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n0.,0.,0., 0.,0.,1.\n",
                    straight = "*ORIENTATION, NAME=O\n1.,0.,0., 0.,1.,0.\n";
  const Eigen::VectorXd here = hz(ring(0.0, cylinder)), there = hz(ring(0.5, cylinder));
  EXPECT_LT((here - there).norm(), 1e-7 * here.norm());
  // Straight fibres are not the same from everywhere: what is tested can fail.
  const Eigen::VectorXd along = hz(ring(0.0, straight)), across = hz(ring(0.5, straight));
  EXPECT_GT((along - across).norm(), 1e-4 * along.norm());
  // Turned by 90 degrees about the axis, 1 runs around and 2 outwards.
  const std::string turned =
      replaced(ring(0.0, cylinder + "3, 90.\n"), "1.E9, 1.E10, 2.E9, .03, .1, .2, 5.E8, 9.E8\n7.E8",
               "1.E10, 1.E9, 2.E9, .3, .2, .1, 5.E8, 7.E8\n9.E8");
  EXPECT_LT((here - hz(turned)).norm(), 1e-7 * here.norm());
}

// A strip of one shell layer, held at one end and pulled at the other: K_xx = E_x b t / l, of uniaxial stress.  The stiffness
// along fibres at an angle is E(a) = 1 / (c^4/E1 + (1/G12 - 2 nu12/E1) c^2 s^2 + s^4/E2) (Jones, Mechanics of Composite Materials, 2.6).
// Averaging ties of two nodes leave the ends free to contract, so that the stress is uniform and elements are exact.
TEST_F(DeckDirections, ALaminaIsStiffAlongItsFibres) {
  const double l = 2.0, b = 0.5, t = 0.01, E1 = 135e9, E2 = 10e9, nu = 0.3, G = 5e9;
  const Plate plate{.lx = l, .ly = b, .t = t, .nx = 8, .ny = 1};
  const std::string kMean = "tie = \"average\"\ndirections = [\"x\", \"y\", \"z\"]\n";
  const std::string ends = "[interface.a]\n" + plate.edge([](int i, int) { return i == 0; }) + kMean +
                           "[interface.b]\n" + plate.edge([](int i, int) { return i == 8; }) + kMean +
                           "[modes]\ncount = 2\n";
  const auto compliance = [&](const Reduced& r) {
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    // The interfaces leave the turn about x free, so that a third one holds the body's mean motion: it is let go here.
    Eigen::MatrixXd K(7, 7);
    K << r.se.K_se.block(3, 3, 1, 1), r.se.K_se.block(3, 6, 1, 6),  //
        r.se.K_se.block(6, 3, 6, 1), r.se.K_se.block(6, 6, 6, 6);
    return Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(K).pseudoInverse().eval()(0, 0);
  };
  const auto exact = [&](double degrees) {
    const double a = degrees * std::numbers::pi / 180, c = std::cos(a) * std::cos(a), s = 1 - c;
    return l / (b * t) * (c * c / E1 + (1 / G - 2 * nu / E1) * c * s + s * s / E2);
  };
  const std::string mat8 = "MAT8,1,1.35+11,1.+10,.3,5.+9,5.+9,5.+9,1600.";
  const auto nastran = [&](const std::string& theta, const std::string& property, const std::string& more) {
    std::string deck = plate.nastran(more);
    deck = replaced(deck, fmt::format("MAT1,1,{:.9e},,{},{}", plate.E, plate.nu, plate.rho), mat8);
    deck = replaced(deck, fmt::format("PSHELL,1,1,{},1,,1", t), property);
    for (std::size_t at = deck.find("CQUAD4"); at != std::string::npos; at = deck.find("CQUAD4", at + 1))
      deck.insert(deck.find('\n', at), "," + theta);
    return deck;
  };
  const std::string shell = fmt::format("PSHELL,1,1,{},1,,1", t);
  for (const double angle : {0.0, 90.0}) {
    EXPECT_NEAR(compliance(reduce_deck(nastran(fmt::format("{}.", angle), shell, ""), ends)), exact(angle),
                1e-6 * exact(angle))
        << angle;
    // Layers of one material in one direction are one layer.
    EXPECT_NEAR(
        compliance(reduce_deck(
            nastran("0.", fmt::format("PCOMP,1,,,,,,,SYM\n,1,{},{}.,,1,{},{}.", t / 4, angle, t / 4, angle),
                    ""),
            ends)),
        exact(angle), 1e-6 * exact(angle))
        << angle;
  }
  // MCID whose x axis is the plate's y.
  EXPECT_NEAR(compliance(reduce_deck(nastran("7", shell, "CORD2R,7,0,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n"), ends)),
              exact(90), 1e-6 * exact(90));
  // Abaqus: LAMINA, directions by ORIENTATION, whose axis 2 is laid into the shell where the turn is about 1, and 1 where it is about 3.
  const auto abaqus = [&](const std::string& orientation, const std::string& parameter) {
    std::string deck = replaced(plate.abaqus(), "MATERIAL=STEEL\n", "MATERIAL=STEEL" + parameter + "\n");
    deck = replaced(deck, fmt::format("*ELASTIC\n{:.9e}, {}\n", plate.E, plate.nu),
                    "*ELASTIC, TYPE=LAMINA\n1.35E11, 1.E10, .3, 5.E9, 5.E9, 5.E9\n");
    return replaced(deck, "*SHELL SECTION", orientation + "*SHELL SECTION");
  };
  EXPECT_NEAR(compliance(reduce_inp(abaqus("", ""), ends)), exact(0), 1e-6 * exact(0));
  EXPECT_NEAR(compliance(reduce_inp(
                  abaqus("*ORIENTATION, NAME=O\n1.,0.,0., 0.,1.,0.\n3, 90.\n", ", ORIENTATION=O"), ends)),
              exact(90), 1e-6 * exact(90));
  EXPECT_NEAR(
      compliance(reduce_inp(abaqus("*ORIENTATION, NAME=O\n1.,0.,0., 0.,1.,0.\n", ", ORIENTATION=O"), ends)),
      exact(90), 1e-6 * exact(90));
}

}  // namespace
}  // namespace flexura::test
