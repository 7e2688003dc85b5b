// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What Nastran decks of users say beside elements and nodes: defaults, axes of vectors, parameters, ties that carry elements.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "tests/found/parts.hpp"
#include "tests/reference.hpp"

namespace flexura::test {
namespace {

using Eigen::VectorXd;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

using DeckNastran = Parts;

constexpr double E = 2.1e11, A = 1.5e-3, I_z = 3.125e-7, I_y = 1.125e-7, rho = 7850.0;
// Without shear factors: Euler and Bernoulli's beam.
const std::string kHead = "BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\nPBAR,1,1,1.5-3,3.125-7,1.125-7,2.-7\n";

std::string ends(int a, int b) {
  return fmt::format(
      "[interface.a]\nby = \"nodes\"\nnodes = [{}]\n[interface.b]\nby = \"nodes\"\nnodes = "
      "[{}]\n[modes]\ncount = 2\n",
      a, b);
}

VectorXd unit(int d) {
  return VectorXd::Unit(6, d);
}

// MacNeal and Harder's straight cantilever, 6 x 0.2 x 0.1 of six bricks: Nastran's HEXA(8) with bubble functions gave 0.978 and
// 0.973 of beam theory (Finite Elements in Analysis and Design 1, 1985, table 3).  Where the deck leaves it open (programs
// differ there), the part file says, and what is taken is told: without them 0.093 and 0.025.
TEST_F(DeckNastran, BricksHaveBubblesWhereTheyAreAskedFor) {
  const auto deck = [](const std::string& solid) {
    std::string text = "BEGIN BULK\nMAT1,1,1.+7,,0.3,1.\n" + solid;
    for (int i = 0, k = 0; i <= 6; ++i)
      for (const auto& [y, z] : {std::pair(0.0, 0.0), {0.2, 0.0}, {0.2, 0.1}, {0.0, 0.1}})
        text += fmt::format("GRID,{},,{}.,{},{}\n", ++k, i, y, z);
    for (int a = 0; a < 24; a += 4)
      text += fmt::format("CHEXA,{},1,{},{},{},{},{},{}\n,{},{}\n", a / 4 + 1, a + 1, a + 2, a + 3, a + 4,
                          a + 5, a + 6, a + 7, a + 8);
    return text + "ENDDATA\n";
  };
  const std::string rest =
      "[interface.a]\nby = \"nodes\"\nnodes = [1, 2, 3, 4]\n[interface.b]\nby = \"nodes\"\nnodes = [25, 26, "
      "27, 28]\n"
      "tie = \"average\"\n[modes]\ncount = 1\n";
  const Reduced r = reduce_deck(deck("PSOLID,1,1,,BUBBLE\n"), rest);
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  expect_reference("straight beam of six CHEXA, load in its plane", "of beam theory",
                   statics(r.se, 0, 1, unit(1))(7) / 0.1081, 0.978, 0.01,
                   {"MacNeal and Harder 1985", "one per cent: the element is another one with bubbles"});
  expect_reference("straight beam of six CHEXA, load out of it", "of beam theory",
                   statics(r.se, 0, 1, unit(2))(8) / 0.4321, 0.973, 0.01,
                   {"MacNeal and Harder 1985", "one per cent: the element is another one with bubbles"});
  const Reduced enhanced = reduce_deck(deck("PSOLID,1,1\n"), rest + "[mesh]\nformulation = \"enhanced\"\n");
  ASSERT_EQ(enhanced.outcome.exit_code, 0) << enhanced.outcome.err;
  EXPECT_LT((enhanced.se.K_se - r.se.K_se).norm(), 1e-9 * r.se.K_se.norm());
  const Reduced full = reduce_deck(deck("PSOLID,1,1\n"), rest);
  EXPECT_LT(statics(full.se, 0, 1, unit(1))(7) / 0.1081, 0.1);
  EXPECT_THAT(full.outcome.out,
              HasSubstr("6 CHEXA of eight nodes, whose PSOLID leaves IN blank: integrated in full"));
}

// In English units masses are weights: WTMASS divides by g.  In the bulk data, in the case control.
TEST_F(DeckNastran, ParameterWtmassScalesAllMasses) {
  const std::string bulk =
      kHead + "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nCBAR,1,1,1,2,0.,1.,0.\nCONM2,9,2,,3.\n,.5,,.5,,,.5\n";
  for (const std::string& deck :
       {bulk + "PARAM,WTMASS,.01\nENDDATA\n", "SOL 103\nparam, wtmass, 0.01\nCEND\n" + bulk + "ENDDATA\n"}) {
    const Reduced r = reduce_deck(deck, ends(1, 2));
    ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    EXPECT_NEAR(r.se.inertia.mass, 0.01 * (rho * A + 3), 1e-12);
    EXPECT_THAT(r.outcome.out, HasSubstr("WTMASS"));
  }
}

// BAROR, cards in small letters, vectors in the axes that OFFT names: a bar along y with its node 0.1 off its axis along -z.
TEST_F(DeckNastran, DefaultsAndAxesOfVectors) {
  const auto deck = [](const std::string& bars) {
    return kHead + "GRID,1,,0.,0.,0.\nGRID,2,,0.,1.,0.\n" + bars + "ENDDATA\n";
  };
  const auto stretch = [&](const std::string& bars) {
    const Reduced r = reduce_deck(deck(bars), ends(1, 2));
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    EXPECT_EQ(r.outcome.err, "");
    return statics(r.se, 0, 1, unit(1));
  };
  // y of the element is X, z is -Z: an offset along z bends about the element's y.
  const double exact = 1 / (E * A) + 0.01 / (E * I_y);
  EXPECT_NEAR(stretch("CBAR,1,1,1,2,1.,0.,0.\n,,,0.,0.,.1,0.,0.,.1\n")(7) / exact, 1.0, 1e-12);
  EXPECT_NEAR(stretch("CBAR,1,1,1,2,1.,0.,0.,GOO\n,,,0.,0.,.1,0.,0.,.1\n")(7) / exact, 1.0, 1e-12);
  EXPECT_NEAR(stretch("CBAR,1,1,1,2,1.,0.,0.,BGO\n,,,0.,0.,-.1,0.,0.,.1\n")(7) / exact, 1.0, 1e-12);
  EXPECT_NEAR(stretch("baror,,1,,,1.,0.,0.\ncbar,1,,1,2\n,,,0.,0.,.1,0.,0.,.1\n")(7) / exact, 1.0, 1e-12);
  // GOO's x lies along the bar: nothing but a shorter one.
  EXPECT_NEAR(stretch("CBAR,1,1,1,2,1.,0.,0.,GOO\n,,,.25,0.,0.,-.25,0.,0.\n")(7) * E * A, 0.5, 1e-12);
  EXPECT_THAT(reduce_deck(deck("CBAR,1,1,1,2,1.,0.,0.,XYZ\n"), ends(1, 2)).outcome.err,
              HasSubstr("OFFT of CBAR 1 is \"XYZ\""));
}

// RBE2 of some directions is a hinge.  Two bars, clamped at both outer ends, hinged about z in the middle: turning an end takes
// 1.5 EI/l (2 EI/l without the hinge, of two bars of length l).
TEST_F(DeckNastran, RigidElementsOfSomeDirectionsAreHinges) {
  const auto deck = [](const std::string& axes, const std::string& components) {
    return kHead +
           "CORD2R,9,,0.,0.,0.,0.,-1.,0.\n,1.,0.,0.\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,0.,0.," +
           axes + "\nGRID,4,,2.,0.,0.\nCBAR,1,1,1,2,0.,1.,0.\nCBAR,2,1,4,3,0.,1.,0.\nRBE2,7,2," + components +
           ",3\nENDDATA\n";
  };
  const auto turn = [&](const std::string& axes, const std::string& components) {
    const Reduced r = reduce_deck(deck(axes, components), ends(1, 4));
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    return r.outcome.exit_code == 0 ? r.se.K_se(11, 11) / (E * I_z) : 0.0;
  };
  EXPECT_NEAR(turn("", "123456"), 2.0, 1e-9);
  EXPECT_NEAR(turn("", "12345"), 1.5, 1e-9);
  EXPECT_NEAR(turn("9", "12346"), 1.5, 1e-9);  // axes x, z, -y
  // A slide along x carries the bars' bending, no tension.
  const Reduced slide = reduce_deck(deck("", "23456"), ends(1, 4));
  ASSERT_EQ(slide.outcome.exit_code, 0) << slide.outcome.err;
  EXPECT_NEAR(slide.se.K_se(11, 11) / (E * I_z), 2.0, 1e-9);
  EXPECT_LT(std::abs(slide.se.K_se(6, 6)), 1e-9 * E * A);
}

// RBE3 whose reference node carries a bar and a mass.  Four bars of length 1 at y, z = +-b, their far ends on one rigid
// element; the fifth bar hangs on the mean of the others' ends.
TEST_F(DeckNastran, AveragesCarryElementsAndMasses) {
  const double b = 0.1, k = E * A;
  std::string text = kHead;
  int n = 0;
  for (const auto& [y, z] : {std::pair(b, b), {-b, b}, {-b, -b}, {b, -b}}) {
    ++n;
    text += fmt::format("GRID,{},,0.,{},{}\nGRID,{},,1.,{},{}\nCBAR,{},1,{},{},0.,1.,0.\n", n, y, z, 10 + n,
                        y, z, n, n, 10 + n);
  }
  text +=
      "GRID,9,,0.,0.,0.\nRBE2,30,9,123456,1,2,3,4\nGRID,20,,1.,0.,0.\nGRID,21,,1.5,0.,0.\nCBAR,9,1,20,21,0.,"
      "1.,0.\n";
  const std::string rbe3 = "RBE3,31,,20,123456,1.,123,11,12\n,13,14\n",
                    mass = "CONM2,40,20,,2.,.1,0.,0.\n,.03,0.,.04,0.,0.,.05\n";
  const Reduced r = reduce_deck(text + rbe3 + mass + "ENDDATA\n", ends(9, 21));
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  EXPECT_THAT(r.outcome.out, HasSubstr("hang on the mean motion of its 4 nodes"));
  EXPECT_NEAR(statics(r.se, 0, 1, unit(0))(6) / (1 / (4 * k) + 0.5 / k), 1.0, 1e-9);
  // A moment about z: forces along the bars, y_i M / sum y^2.
  EXPECT_NEAR(statics(r.se, 0, 1, unit(5))(11) / (1 / (4 * b * b * k) + 0.5 / (E * I_z)), 1.0, 1e-9);
  EXPECT_NEAR(r.se.inertia.mass, rho * A * 4.5 + 2, 1e-9);
  EXPECT_NEAR(r.se.inertia.S_x(0), rho * A * (4 * 0.5 + 0.5 * 1.25) + 2 * 1.1, 1e-9);
  // int x^2 dm of the mass: (J_yy + J_zz - J_xx) / 2 + m x^2.
  EXPECT_NEAR(r.se.inertia.S_xx(0, 0),
              rho * A * (4.0 / 3 + (1.5 * 1.5 * 1.5 - 1) / 3) + 0.5 * (0.04 + 0.05 - 0.03) + 2 * 1.21, 1e-9);
  // As an interface itself, named by its reference node or as a tie.
  const std::string as_tie =
      "[interface.a]\nby = \"nodes\"\nnodes = [9]\n[interface.b]\nby = \"tie\"\nelement = 31\n[modes]\ncount "
      "= 2\n";
  for (const std::string& rest : {ends(9, 20), as_tie}) {
    const Reduced own = reduce_deck(text + rbe3 + mass + "ENDDATA\n", rest);
    ASSERT_EQ(own.outcome.exit_code, 0) << own.outcome.err;
    EXPECT_NEAR(statics(own.se, 0, 1, unit(0))(6) * 4 * k, 1.0, 1e-9);
  }
  const auto refusal = [&](const std::string& more) {
    const Reduced bad = reduce_deck(text + more + "ENDDATA\n", ends(9, 21));
    EXPECT_EQ(bad.outcome.exit_code, 2) << more;
    return bad.outcome.err;
  };
  EXPECT_THAT(refusal("RBE3,31,,20,123,1.,123,11,12\n,13,14\n"),
              HasSubstr("gives only some of the six motions"));
  EXPECT_THAT(refusal("RBE3,31,,20,123456,1.,123,11,12\n"), HasSubstr("lie in a point or on a line"));
}

// What is computed otherwise than the deck says is a warning, what cannot be is refused by name.
TEST_F(DeckNastran, WhatIsOtherwiseIsSaid) {
  const std::string bar = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nCBAR,1,1,1,2,0.,1.,0.\n";
  const auto said = [&](const std::string& more) {
    return reduce_deck(kHead + bar + more + "ENDDATA\n", ends(1, 2)).outcome;
  };
  EXPECT_THAT(said("NSM,1,PBAR,1,.5\n").err,
              HasSubstr("warning: NSM: the mass or stiffness that it adds is missing"));
  EXPECT_THAT(said("PBEAM,2,1,1.-3,1.-7,1.-7,0.,1.-7\n,,,,,,,,\n,YES,1.,1.-3,.5-7\nGRID,3,,2.,0.,0.\nCBEAM,2,"
                   "2,2,3,0.,1.,0.\n")
                  .err,
              HasSubstr("warning: PBEAM's taper: end A is used all along"));
  EXPECT_THAT(
      said("MAT2,5,1.+10,1.+9,0.,1.+10,0.,1.+9\nPSHELL,5,5,.01\nGRID,3,,1.,1.,0.\nCTRIA3,9,5,1,2,3\n").err,
      HasSubstr("material \"5\" has no density above zero"));
  EXPECT_THAT(said("PBUSH,7,K,1.+6,1.+6,1.+6,1.+6,1.+6,1.+6\n,,M,3.\nGRID,4,,1.,0.,0.\nGRID,5,,2.,0.,0."
                   "\nCBAR,3,1,4,5,0.,1.,0.\nCBUSH,8,7,2,4,,,,0\n")
                  .err,
              HasSubstr("PBUSH's M: the mass that it adds is missing"));
  EXPECT_THAT(said("GRID,4,,1.,0.,0.\nRBE2,8,2,,4\n").err, HasSubstr("RBE2 8 names no directions"));
  EXPECT_THAT(said("PARAM,K6ROT,1.\nPARAM,GRDPNT,0\n").out,
              AllOf(HasSubstr("PARAM K6ROT"), HasSubstr("PARAM GRDPNT")));
}

// A bushing of two nodes apart: sideways stiffness at S along it, here at its second node.
TEST_F(DeckNastran, BushingsActAtTheirPlace) {
  const auto K = [&](const std::string& place) {
    const Reduced r = reduce_deck(
        kHead +
            "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.5,0.,0.\nGRID,4,,2.5,0.,0.\nCBAR,1,1,1,2,0.,1.,0."
            "\n"
            "CBAR,2,1,3,4,0.,1.,0.\nPBUSH,5,K,1.+6,1.+6,1.+6,1.+5,1.+5,1.+5\nCBUSH,9,5,2,3,0.,1.,0.,,\n," +
            place + "\nENDDATA\n",
        ends(1, 4));
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    return statics(r.se, 0, 1, unit(1))(7);
  };
  // A force at 4 acts on the bushing's turn, 1e5 N m, by its arm: 1.5 - S/2.  Its rest is the same.
  const auto by_turn = [](double s) { return std::pow(1.5 - 0.5 * s, 2) / 1e5; };
  EXPECT_NEAR((K("1.") - K("0.")) / (by_turn(1) - by_turn(0)), 1.0, 1e-6);
}

}  // namespace
}  // namespace flexura::test
