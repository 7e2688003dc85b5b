// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What Abaqus decks of users say beside elements and nodes: beams of three nodes, axes, springs, what is computed otherwise.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tests/found/parts.hpp"

namespace flexura::test {
namespace {

using Eigen::VectorXd;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class DeckAbaqus : public Parts {
 protected:
  Reduced reduce_inp(const std::string& deck, const std::string& rest) {
    return reduce_deck(deck, "unit = \"m\"\n" + rest, {}, "deck.inp");
  }
};

constexpr double E = 2.1e11, A = 1.5e-3, I_z = 3.125e-7;  // 50 mm along y, 30 mm along z
const std::string kSteel = "*MATERIAL, NAME=S\n*ELASTIC\n2.1E11,.3\n*DENSITY\n7850.\n";

std::string section(const std::string& set) {
  return "*BEAM SECTION, ELSET=" + set + ", MATERIAL=S, SECTION=RECT\n.05,.03\n0.,1.,0.\n";
}
std::string ends(int a, int b) {
  return fmt::format(
      "[interface.a]\nby = \"nodes\"\nnodes = [{}]\n[interface.b]\nby = \"nodes\"\nnodes = "
      "[{}]\n[modes]\ncount = 2\n",
      a, b);
}
VectorXd unit(int d) {
  return VectorXd::Unit(6, d);
}

// A beam of three nodes bends as two of two: exact under end loads.
TEST_F(DeckAbaqus, BeamsAndTrussesOfThreeNodes) {
  const std::string nodes = "*NODE\n1, 0.,0.,0.\n2, 1.,0.,0.\n3, .5,0.,0.\n9, 0.,5.,0.\n";
  const Reduced two =
      reduce_inp(nodes + "*ELEMENT, TYPE=B31, ELSET=B\n1, 1,3\n2, 3,2\n" + section("B") + kSteel, ends(1, 2));
  ASSERT_EQ(two.outcome.exit_code, 0) << two.outcome.err;
  for (const char* nodes_of : {"1,3,2", "1,3,2, 9"}) {
    const Reduced three = reduce_inp(
        nodes + "*ELEMENT, TYPE=B32, ELSET=B\n1, " + nodes_of + "\n" + section("B") + kSteel, ends(1, 2));
    ASSERT_EQ(three.outcome.exit_code, 0) << three.outcome.err;
    EXPECT_THAT(three.outcome.out, HasSubstr("1 element of type B32: each taken as two straight ones"));
    EXPECT_LT((three.se.K_se - two.se.K_se).norm(), 1e-12 * two.se.K_se.norm());
    EXPECT_NEAR(statics(three.se, 0, 1, unit(1))(7) * 3 * E * I_z, 1.0, 0.01);  // shear: 0.2 %
  }
  const Reduced truss = reduce_inp(
      nodes + "*ELEMENT, TYPE=B31, ELSET=B\n1, 1,3\n2, 3,2\n*ELEMENT, TYPE=T3D3, ELSET=T\n3, 1,3,2\n" +
          section("B") + "*SOLID SECTION, ELSET=T, MATERIAL=S\n1.5E-3\n" + kSteel,
      ends(1, 2));
  ASSERT_EQ(truss.outcome.exit_code, 0) << truss.outcome.err;
  EXPECT_NEAR(statics(truss.se, 0, 1, unit(0))(6) * 2 * E * A, 1.0, 1e-9);
}

// SPRING2 between nodes in one place, in axes of an ORIENTATION; SPRING1 is to the ground.
TEST_F(DeckAbaqus, SpringsInDirections) {
  const double k = 1e7;
  const std::string deck =
      "*NODE\n1, 0.,0.,0.\n2, 1.,0.,0.\n3, 1.,0.,0.\n4, 2.,0.,0.\n*ELEMENT, TYPE=B31, ELSET=B\n1, 1,2\n2, "
      "3,4\n" +
      section("B") + "*ORIENTATION, NAME=O\n0.,1.,0., -1.,0.,0.\n";
  std::string springs;
  for (int d = 1; d <= 6; ++d)
    springs += fmt::format(
        "*ELEMENT, TYPE=SPRING2, ELSET=K{0}\n1{0}, 2,3\n*SPRING, ELSET=K{0}{2}\n{0}, {0}\n{1:g}\n", d,
        d == 2 ? k : 1e9, d <= 2 ? ", ORIENTATION=O" : "");  // 1 along y, 2 along -x
  const Reduced r = reduce_inp(deck + springs + kSteel, ends(1, 4));
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  EXPECT_NEAR(statics(r.se, 0, 1, unit(0))(6) / (2 / (E * A) + 1 / k), 1.0, 1e-9);
  const Reduced ground = reduce_inp(
      deck + springs + "*ELEMENT, TYPE=SPRING1, ELSET=G\n77, 4\n*SPRING, ELSET=G\n1\n5.\n" + kSteel,
      ends(1, 4));
  ASSERT_EQ(ground.outcome.exit_code, 0) << ground.outcome.err;
  EXPECT_THAT(ground.outcome.out, HasSubstr("SPRING1: to the ground"));
  const Reduced apart = reduce_inp(
      "*NODE\n1, 0.,0.,0.\n2, 1.,0.,0.\n*ELEMENT, TYPE=B31, ELSET=B\n1, 1,2\n*ELEMENT, TYPE=SPRING2, "
      "ELSET=K\n2, 1,2\n"
      "*SPRING, ELSET=K\n2,2\n1.\n" +
          section("B") + kSteel,
      ends(1, 2));
  EXPECT_EQ(apart.outcome.exit_code, 2);
  EXPECT_THAT(apart.outcome.err, HasSubstr("a turn of the whole body would strain it"));
}

// Axes by ORIENTATION: of moments of inertia, and of an orthotropic solid, whose directions 1 and 2 change places.
TEST_F(DeckAbaqus, OrientationsTurn) {
  const std::string beam =
      "*NODE\n1, 0.,0.,0.\n2, 1.,0.,0.\n*ELEMENT, TYPE=B31, ELSET=B\n1, 1,2\n" + section("B") +
      "*ELEMENT, TYPE=ROTARYI, ELSET=R\n5, 2\n*ELEMENT, TYPE=MASS, ELSET=M\n6, 2\n*MASS, ELSET=M\n2.\n";
  const auto turned = [&](const std::string& orientation, const std::string& parameter) {
    const Reduced r = reduce_inp(
        beam + orientation + "*ROTARY INERTIA, ELSET=R" + parameter + "\n.1,.25,.3\n" + kSteel, ends(1, 2));
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    return Eigen::Vector2d(r.se.M_se(9, 9), r.se.M_se(10, 10));  // about x and y
  };
  const Eigen::Vector2d plain = turned("", ""), swapped(0.15, -0.15);
  EXPECT_LT(
      (turned("*ORIENTATION, NAME=O\n0.,1.,0., -1.,0.,0.\n", ", ORIENTATION=O") - plain - swapped).norm(),
      1e-9);
  EXPECT_LT(
      (turned("*ORIENTATION, NAME=O\n1.,0.,0., 0.,1.,0.\n3, 90.\n", ", ORIENTATION=O") - plain - swapped)
          .norm(),
      1e-9);

  const auto wood = [&](const std::string& constants, const std::string& orientation) {
    std::string text = "*NODE\n";
    for (int i = 0, k = 0; i < 3; ++i)
      for (const auto& [y, z] : {std::pair(0.0, 0.0), {.1, 0.0}, {.1, .1}, {0.0, .1}})
        text += fmt::format("{}, {},{},{}\n", ++k, .1 * i, y, z);
    return text +
           "*ELEMENT, TYPE=C3D8I, ELSET=E\n1, 1,2,3,4, 5,6,7,8\n2, 5,6,7,8, 9,10,11,12\n*ORIENTATION, "
           "NAME=O\n0.,1.,0., -1.,0.,0.\n"
           "*SOLID SECTION, ELSET=E, MATERIAL=W" +
           orientation + "\n*MATERIAL, NAME=W\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n" + constants +
           "\n*DENSITY\n500.\n";
  };
  const std::string foot = "[interface.foot]\nby = \"nodes\"\nnodes = [1, 2, 3, 4]\n[modes]\ncount = 4\n";
  // E1 E2 E3 nu12 nu13 nu23 G12 G13 / G23, and with 1 and 2 exchanged: nu21 = nu12 E2 / E1.
  const Reduced a = reduce_inp(wood("1.E10, 1.E9, 2.E9, .3, .2, .1, 5.E8, 7.E8\n9.E8", ", ORIENTATION=O"),
                               foot),
                b = reduce_inp(wood("1.E9, 1.E10, 2.E9, .03, .1, .2, 5.E8, 9.E8\n7.E8", ""), foot);
  ASSERT_EQ(a.outcome.exit_code, 0) << a.outcome.err;
  ASSERT_EQ(b.outcome.exit_code, 0) << b.outcome.err;
  EXPECT_LT((a.se.omega2 - b.se.omega2).norm(), 1e-9 * b.se.omega2.norm());
  const Reduced by_nodes =
      reduce_inp(replaced(wood("1.E10, 1.E9, 2.E9, .3, .2, .1, 5.E8, 7.E8\n9.E8", ", ORIENTATION=O"),
                          "NAME=O\n", "NAME=O, DEFINITION=NODES\n"),
                 foot);
  EXPECT_EQ(by_nodes.outcome.exit_code, 2);
  EXPECT_THAT(by_nodes.outcome.err, HasSubstr("DEFINITION=NODES, which is not read"));
}

// *TIE with ADJUST=NO: nodes follow from where they stand, by rigid arms.
TEST_F(DeckAbaqus, TiesThatDoNotAdjust) {
  // Beams without shear: 1 long, a gap of g, 1 long.
  const double g = 0.01, EI = E * I_z, l = 1.0, arm = l + g;
  const auto beams = [&](const std::string& adjust) {
    return reduce_inp(
        fmt::format("*NODE\n1, 0.,0.,0.\n2, 1.,0.,0.\n3, {},0.,0.\n4, {},0.,0.\n*ELEMENT, TYPE=B33, "
                    "ELSET=B\n1, 1,2\n2, 3,4\n",
                    1 + g, 2 + g) +
            section("B") +
            "*SURFACE, NAME=LEFT, TYPE=NODE\n2\n*SURFACE, NAME=RIGHT, TYPE=NODE\n3\n*TIE, NAME=T, "
            "POSITION TOLERANCE=.02" +
            adjust + "\nRIGHT, LEFT\n" + kSteel,
        ends(1, 4));
  };
  const Reduced stays = beams(", ADJUST=NO");
  ASSERT_EQ(stays.outcome.exit_code, 0) << stays.outcome.err;
  EXPECT_THAT(stays.outcome.out, HasSubstr("by rigid arms (ADJUST=NO)"));
  const double root = l * l * l / (3 * EI) + arm * l * l / (2 * EI), turn = l * l / (2 * EI) + arm * l / EI;
  EXPECT_NEAR(statics(stays.se, 0, 1, unit(1))(7) / (root + turn * arm + l * l * l / (3 * EI)), 1.0, 1e-9);
  EXPECT_NEAR(statics(stays.se, 0, 1, unit(0))(6) * E * A / 2, 1.0, 1e-9);
  const Reduced moves = beams("");
  EXPECT_NEAR(statics(moves.se, 0, 1, unit(0))(6) * E * A / (2 + g), 1.0, 1e-9);  // node 3 moved onto 2

  // Blocks of one and of four bricks with a gap of 4 mm.
  const auto block = [](const std::string& name, double x0, int n, int first) {
    std::string text = "*NODE\n";
    const auto node = [&](int i, int j, int k) { return first + i * (n + 1) * (n + 1) + j * (n + 1) + k; };
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j <= n; ++j)
        for (int k = 0; k <= n; ++k)
          text += fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", node(i, j, k), x0 + 0.1 * i, 0.1 * j / n,
                              0.1 * k / n);
    text += "*ELEMENT, TYPE=C3D8I, ELSET=" + name + "\n";
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        text += fmt::format("{}, {},{},{},{}, {},{},{},{}\n", first + j * n + k, node(0, j, k),
                            node(0, j + 1, k), node(0, j + 1, k + 1), node(0, j, k + 1), node(1, j, k),
                            node(1, j + 1, k), node(1, j + 1, k + 1), node(1, j, k + 1));
    return text + fmt::format(
                      "*SOLID SECTION, ELSET={0}, MATERIAL=S\n*SURFACE, NAME={0}-LOW\n{0}, S1\n*SURFACE, "
                      "NAME={0}-HIGH\n{0}, S2\n",
                      name);
  };
  const std::string faces =
      "[interface.foot]\nby = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\ntie = \"average\"\n"
      "[interface.tip]\nby = \"plane\"\npoint = [0.204, 0, 0]\nnormal = [1, 0, 0]\ntie = "
      "\"average\"\n[modes]\ncount = 2\n";
  const auto stretch = [&](const std::string& adjust) {
    const Reduced r = reduce_inp(block("A", 0.0, 1, 1) + block("B", 0.104, 2, 1000) + kSteel +
                                     "*TIE, NAME=T, POSITION TOLERANCE=.005" + adjust + "\nB-LOW, A-HIGH\n",
                                 faces);
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    EXPECT_EQ(r.outcome.out.find("ADJUST=NO") != std::string::npos, !adjust.empty());
    return statics(r.se, 0, 1, unit(0))(6) * E * 0.01;
  };
  EXPECT_NEAR(stretch(", ADJUST=NO"), 0.2, 1e-9);
  EXPECT_NEAR(stretch(""), 0.204, 1e-9);
}

// What is computed otherwise than the deck says is a warning; elements that are not read do not make their sets unknown.
TEST_F(DeckAbaqus, WhatIsOtherwiseIsSaid) {
  const std::string beam =
      "*NODE, NSET=ALL\n1, 0.,0.,0.\n2, 1.,0.,0.\n3, 1.2,0.,0.\n4, 2.,0.,0.\n*ELEMENT, TYPE=B31, ELSET=B\n1, "
      "1,2\n2, 3,4\n" +
      section("B") + kSteel;
  const auto said = [&](const std::string& more) {
    const Outcome outcome = reduce_inp(beam + more, ends(1, 4)).outcome;
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(said("*MPC\nTIE, 3, 2\n"),
              HasSubstr("warning: *MPC TIE of nodes that stand 0.2 apart: they are joined by a rigid arm"));
  EXPECT_THAT(said("*MPC\nBEAM, 3, 2\n"), Not(HasSubstr("*MPC")));
  EXPECT_THAT(said("*MPC\nBEAM, 3, 2\n*NONSTRUCTURAL MASS, ELSET=B, UNITS=TOTAL MASS\n5.\n"),
              HasSubstr("warning: *NONSTRUCTURAL MASS: the mass that it adds is missing"));
  EXPECT_THAT(said("*MPC\nBEAM, 3, 2\n*TRANSVERSE SHEAR STIFFNESS\n1.,1.,0.\n"),
              HasSubstr("shear deformation is that of the section"));
  EXPECT_THAT(
      said(
          "*MPC\nBEAM, 3, 2\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n9, 1,2\n*SOLID SECTION, ELSET=C, MATERIAL=S\n"),
      HasSubstr("warning: 1 element CONN3D2 is not used"));
}

}  // namespace
}  // namespace flexura::test
