// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Decks as a whole: mixed elements, meshes written for other programs, what is not read.
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

using testing::AllOf;
using testing::HasSubstr;
constexpr double kPi = std::numbers::pi;

using Decks = Parts;

// A block of solids whose face carries a sheet on a spider of its own: one body.
TEST_F(Decks, SolidsShellsAndBeamsMakeOneBody) {
  const std::string text =
      "BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\nPSOLID,1,1\nPSHELL,2,1,0.01,1,,1\nPBARL,3,1,,ROD\n,0.01\n"
      "GRID,1,,0.,0.,0.\nGRID,2,,.1,0.,0.\nGRID,3,,.1,.1,0.\nGRID,4,,0.,.1,0.\nGRID,5,,0.,0.,.1\nGRID,6,,.1,"
      "0.,.1\n"
      "GRID,7,,.1,.1,.1\nGRID,8,,0.,.1,.1\nCHEXA,1,1,1,2,3,4,5,6\n,7,8\n"
      "GRID,11,,0.1,0.,.05\nGRID,12,,0.4,0.,.05\nGRID,13,,0.4,.1,.05\nGRID,14,,0.1,.1,.05\nCQUAD4,2,2,11,12,"
      "13,14\n"
      "GRID,20,,0.1,0.05,0.05\nRBE2,30,20,123456,2,3,6,7,11,14\n"
      "GRID,21,,1.,0.,.05\nCBAR,3,3,12,21,0.,1.,0.\nENDDATA\n";
  const Reduced r = reduce_deck(
      text,
      "[interface.foot]\nby = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\n[interface.tip]\nby = "
      "\"nodes\"\nnodes = [21]\n[modes]\ncount = 5\n");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  EXPECT_NEAR(r.se.inertia.mass, 7850 * (0.001 + 0.3 * 0.1 * 0.01 + 0.6 * kPi * 1e-4), 1e-9);
  EXPECT_THAT(r.outcome.out, HasSubstr("1 beams and rods"));
}

// The mesh written for other programs, read again, is the same part.
TEST_F(Decks, MeshesAreWrittenForOtherPrograms) {
  const std::string
      material = "[material.steel]\nyoung = \"210 GPa\"\npoisson = 0.3\ndensity = 7850\n",
      foot = "[interface.foot]\nby = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\n[modes]\ncount = 3\n";
  // Two wedges and a brick with bubbles: Abaqus and Nastran both have it.
  const std::string deck =
      "BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\nPSOLID,1,1,,BUBBLE\n"
      "GRID,1,,0.,0.,0.\nGRID,2,,.1,0.,0.\nGRID,3,,.1,.1,0.\nGRID,4,,0.,.1,0.\nGRID,5,,0.,0.,.1\nGRID,6,,.1,"
      "0.,.1\n"
      "GRID,7,,.1,.1,.1\nGRID,8,,0.,.1,.1\nGRID,9,,.25,0.,0.\nGRID,10,,.25,.1,0.\nGRID,11,,.25,0.,.1\nGRID,"
      "12,,.25,.1,.1\n"
      "CHEXA,1,1,1,2,3,4,5,6\n,7,8\nCPENTA,2,1,2,9,10,6,11,12\nCPENTA,3,1,2,10,3,6,12,7\nENDDATA\n";
  const Reduced first = reduce_deck(deck, foot, {"--mesh", (folder_ / "again.inp").string()});
  ASSERT_EQ(first.outcome.exit_code, 0) << first.outcome.err;
  reduce_deck(deck, foot, {"--mesh", (folder_ / "again.msh").string()});
  for (const std::string name : {"again.inp", "again.msh"}) {
    // The deck has its materials, the mesh has none.
    const Reduced again =
        reduce_deck(read_text(folder_ / name),
                    "unit = \"m\"\n" +
                        (name == "again.inp" ? "" : "[mesh]\nformulation = \"enhanced\"\n" + material) + foot,
                    {}, name);
    ASSERT_EQ(again.outcome.exit_code, 0) << again.outcome.err;
    EXPECT_NEAR(again.se.inertia.mass, first.se.inertia.mass, 1e-9);
    EXPECT_LT((again.se.omega2 - first.se.omega2).norm(), 1e-8 * first.se.omega2.norm()) << name;
  }
  ASSERT_EQ(reduce_deck(deck, foot, {"--mesh", (folder_ / "again.vtu").string()}).outcome.exit_code, 0);
  EXPECT_THAT(read_text(folder_ / "again.vtu"),
              AllOf(HasSubstr("NumberOfPoints=\"12\" NumberOfCells=\"3\""), HasSubstr("12\n13\n13\n")));
  EXPECT_EQ(reduce_deck(deck, foot, {"--mesh", (folder_ / "again.stl").string()}).outcome.exit_code, 2);
}

// What is not read is listed, and what cannot be is refused by name.
TEST_F(Decks, WhatIsNotReadIsListedOrRefused) {
  const Plate plate{.lx = 1.0, .ly = 1.0, .t = 0.01, .nx = 2, .ny = 2};
  const std::string root =
      "[interface.root]\n" + plate.edge([](int i, int) { return i == 0; }) + "[modes]\ncount = 1\n";
  const Reduced listed =
      reduce_deck(plate.nastran("PLOAD4,1,1,2.\nPLOAD4,1,2,2.\nCELAS2,77,1.+3,5,3\n"), root);
  ASSERT_EQ(listed.outcome.exit_code, 0) << listed.outcome.err;
  EXPECT_THAT(listed.outcome.out, HasSubstr("2 cards PLOAD4"));
  EXPECT_THAT(listed.outcome.out, HasSubstr("CELAS2 to the ground"));
  // An element that is not read makes another body: a warning, not a note.
  const Reduced lacks = reduce_deck(plate.nastran("CSHEAR,77,1,1,3,9,7\n"), root);
  ASSERT_EQ(lacks.outcome.exit_code, 0) << lacks.outcome.err;
  EXPECT_THAT(lacks.outcome.err, HasSubstr("warning: 1 element CSHEAR is not used"));
  EXPECT_THAT(lacks.outcome.out, HasSubstr("with care: "));
  const Reduced thick = reduce_deck(replaced(plate.nastran(), "PSHELL,1,1,0.01", "PSHELL,1,1,10."), root);
  EXPECT_THAT(thick.outcome.err,
              HasSubstr("a shell is 10 m thick where all shells together are 1.41 m long"));
  const auto refusal = [&](const std::string& deck) {
    const Reduced r = reduce_deck(deck, root);
    EXPECT_EQ(r.outcome.exit_code, 2) << r.outcome.err;
    return r.outcome.err;
  };
  EXPECT_THAT(refusal(replaced(plate.nastran(), "PSHELL,1,1,0.01", "PSHELL,1,1,0.")),
              HasSubstr("thickness 0"));
  EXPECT_THAT(refusal(replaced(plate.nastran(), "CQUAD4,1,1,1,2,5,4", "CQUAD4,1,1,1,5,2,4")),
              HasSubstr("inverted or flat"));
  EXPECT_THAT(
      refusal(plate.nastran("PBARL,9,1,,HAT\n,1.,1.,1.,1.\nGRID,50,,5.,0.,0.\nCBAR,60,9,1,50,0.,1.,0.\n")),
      HasSubstr("HAT"));
  EXPECT_THAT(reduce_deck(plate.nastran("CELAS2,77,1.+3,1,3,9,3\n"), root).outcome.err,
              HasSubstr("turn of the whole body"));
}

}  // namespace
}  // namespace flexura::test
