// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Cards of Nastran that are other words for what is tested elsewhere: the same matrices.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/found/parts.hpp"

namespace flexura::test {
namespace {

using Eigen::MatrixXd;
using testing::HasSubstr;

class DeckCards : public Parts {
 protected:
  /// Bars 1-2, 2-3 and 5-4 in a plane; nodes 3 and 5 stand 0.1 apart.
  static std::string frame(const std::string& cards) {
    return "BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\nPBAR,1,1,1.5-3,3.125-7,1.125-7,2.-7\n"
           "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,5,,1.,1.1,0.\nGRID,4,,0.,1.5,0.2\n"
           "CBAR,1,1,1,2,0.,0.,1.\nCBAR,2,1,2,3,0.,0.,1.\nCBAR,3,1,5,4,0.,0.,1.\n" +
           cards + "ENDDATA\n";
  }
  MatrixXd stiffness(const std::string& deck, const std::string& rest = "") {
    const Reduced r =
        reduce_deck(deck,
                    "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\n"
                    "nodes = [4]\n[modes]\ncount = 1\n" +
                        rest);
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    said_ = r.outcome.out + r.outcome.err;
    return r.outcome.exit_code == 0 ? MatrixXd(r.se.K_se.topLeftCorner(12, 12)) : MatrixXd::Zero(12, 12);
  }
  void expect_same(const std::string& cards, const std::string& others, double tolerance = 1e-9) {
    const MatrixXd a = stiffness(frame(cards)), b = stiffness(frame(others));
    EXPECT_LE((a - b).norm(), tolerance * b.norm()) << cards << "\n" << others;
    EXPECT_GT(b.norm(), 1.0);
  }
  const std::string kJoined = "RBE2,9,3,123456,5\n";
  std::string said_;
};

TEST_F(DeckCards, RigidElementsOfOtherNames) {
  expect_same("RBAR,9,3,5,123456\n", kJoined);
  expect_same("RBAR,9,3,5,,123456,123456\n", kJoined);
  expect_same("RBE1,9,3,123456\n,UM,5,123456\n", kJoined);
  // A ball joint, a hinge in the axes of CD.
  expect_same("RBAR,9,3,5,123456,,,123\n", "RBE2,9,3,123,5\n");
  expect_same("RBAR,9,3,5,,123456,123\n", "RBE2,9,5,123,3\n");
  expect_same("RBE1,9,3,123456\n,UM,5,12356\n", "RBE2,9,3,12356,5\n");
  // Three dofs of one and three of the other: named, with what follows from it.
  stiffness(frame(kJoined + "RBAR,10,1,4,123,456\n"));
  EXPECT_THAT(said_, HasSubstr("RBAR whose independent dofs (CNA, CNB) are not all six of one node"));
}

TEST_F(DeckCards, TubesAndRigidRods) {
  const double outer = 0.02, wall = 0.002, a = outer / 2, b = a - wall;
  expect_same(
      kJoined + "PTUBE,3,1,.02,.002\nCTUBE,9,3,1,3\n",
      kJoined + fmt::format("PROD,3,1,{:.17g},{:.17g}\nCROD,9,3,1,3\n", std::numbers::pi * (a * a - b * b),
                            std::numbers::pi / 2 * (std::pow(a, 4) - std::pow(b, 4))));
  expect_same(kJoined + "PTUBE,3,1,.02\nCTUBE,9,3,1,3\n",
              kJoined + fmt::format("PROD,3,1,{:.17g},{:.17g}\nCROD,9,3,1,3\n", std::numbers::pi * a * a,
                                    std::numbers::pi / 2 * std::pow(a, 4)));
  // A rod 1e7 times as stiff as the frame differs by 1e-7 of it.
  expect_same(kJoined + "RROD,9,2,5,1\n", kJoined + "CONROD,9,2,5,1,100.\n", 1e-5);
  EXPECT_THAT(reduce_deck(frame("PTUBE,3,1,.02,.2\nCTUBE,9,3,1,3\n"), "").outcome.err,
              HasSubstr("PTUBE 3 has the wall 0.2; it must be from 0 to half of OD = 0.02"));
}

// At GA = node 3 the system's radius points along (1, 1, 0).
TEST_F(DeckCards, BushesInCylindricalAxes) {
  const std::string springs = "PBUSH,5,K,1.+5,2.+5,3.+5,4.+4,5.+4,6.+4\n";
  expect_same(springs + "CORD2C,8,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nCBUSH,9,5,3,5,,,,8\n",
              springs + "CORD2R,8,,0.,0.,0.,0.,0.,1.\n,1.,1.,0.\nCBUSH,9,5,3,5,,,,8\n");
  // The middle of the line, (1, 1.05, 0), by its place in that system.
  expect_same(
      springs +
          fmt::format("CORD2C,8,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nCBUSH,9,5,3,5,,,,0\n,,8,{:.15g},{:.15g},0.\n",
                      std::sqrt(1 + 1.05 * 1.05), std::atan2(1.05, 1.0) * 180 / std::numbers::pi),
      springs + "CBUSH,9,5,3,5,,,,0\n", 1e-6);
}

// The elastic constants are the deck's.
TEST_F(DeckCards, DensityAloneIsGivenInThePartFile) {
  const std::string deck = frame(kJoined);
  std::string without = deck;
  without.replace(without.find("7850."), 5, "");
  const MatrixXd K = stiffness(deck), same = stiffness(without, "[material.1]\ndensity = 7850\n");
  EXPECT_EQ((K - same).norm(), 0.0);
  EXPECT_THAT(reduce_deck(without, "").outcome.err,
              HasSubstr("material \"1\" has no density above zero (*DENSITY, or RHO of MAT1); give --density "
                        "\"7800 kg/m^3\""));
}

// Pieces are counted by the deck's nodes; interfaces at both ends of a tie leave it nothing to bind.
TEST_F(DeckCards, WhatNothingJoinsAndWhatIsJoinedTwice) {
  const std::string ends =
      "[interface.a]\nby = \"nodes\"\nnodes = [3]\n[interface.b]\nby = \"nodes\"\nnodes = [5]\n";
  EXPECT_THAT(reduce_deck(frame(""), "strict = true\n" + ends).outcome.err,
              HasSubstr("the mesh falls into 2 pieces that nothing joins; the smallest has 2 nodes"));
  EXPECT_THAT(reduce_deck(frame("RBE2,9,3,126,5\n"), ends).outcome.err,
              HasSubstr("leave one of its nodes out of the interfaces"));
}

TEST_F(DeckCards, SpringsAloneAreNoBody) {
  EXPECT_THAT(
      reduce_deck("BEGIN BULK\nGRID,1\nGRID,2,,1.\nPBUSH,5,K,1.,1.,1.\nCBUSH,9,5,1,2,,,,0\n", "").outcome.err,
      HasSubstr("holds springs and dampers alone (CBUSH, CELAS, CDAMP, CVISC), which make no body"));
}

}  // namespace
}  // namespace flexura::test
