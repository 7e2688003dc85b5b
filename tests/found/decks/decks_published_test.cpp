// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Decks of other projects against the displacements that these publish with them.  From MYSTRAN's validation (repositories
// MystranSolver/MYSTRAN_Validation, decks/ with reference_mystran/ and reference_msc/, and larsmei/mystran-validation, eingabe/
// with referenz_werte.json; MIT licence): the data of the decks, written anew, and the digits that MYSTRAN or MSC Nastran printed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "tests/found/decks/published.hpp"

namespace flexura::test {
namespace {

using Eigen::VectorXd;
using testing::HasSubstr;

// A bush is no body: a bar ahead of each of its nodes has the mass, and strains nothing.
std::string bars_ahead_of(int a, int b) {
  return fmt::format(
      "MAT1    99      1.+7            .3      1.\nPBAR    99      99      1.      1.      1.      1.\n"
      "GRID    901             0.      0.      -1.\nCBAR    901     99      {:<8}901     1.      0.      0.\n"
      "GRID    902             0.      0.      99.\nCBAR    902     99      {:<8}902     1.      0.      "
      "0.\nENDDATA\n",
      a, b);
}
const std::string kDensity = "[material.1]\ndensity = 1\n";
const char* const kMystran = "MYSTRAN's validation (MIT), displacements";

// bar_01, bush_01, bush_09's orientation: an inclined bar with shear factors; a bush whose axes come from an orientation vector.
TEST_F(DeckPublished, OneBarAndOneBush) {
  const Reduced bar = reduce_at(
      "SOL 101\nCEND\nBEGIN BULK\n"
      "SPC1           1  123456       1\n"
      "PBAR           1       1    34.2 164.616 57.7125145.7194      0.        +\n"
      "+           -3.8   -2.25     3.8   -2.25     3.8    2.25    -3.8    2.25+\n"
      "+       .8499532.8505404      0.\n"
      "MAT1           1  70000.             .33      0.      0.      0.\n"
      "GRID           1       0      0.      0.      0.       0\n"
      "GRID           2       0     12.    25.2    37.8       0\n"
      "CBAR           1       1       1       2.3113996.5449493.7784989\n"
      "ENDDATA\n",
      {1, 2}, kDensity);
  ASSERT_EQ(bar.outcome.exit_code, 0) << bar.outcome.err;
  compare("bar_01", bar.se, solve(bar.se, {{1, "123456"}}, {{2, {-1200, 300, 750, 0, 0, 0}}}), 2,
          {-4.618988, 1.628426, 0.3918968, -0.03542561, -0.1195456, 0.09094327}, kMystran);
  const Reduced bush = reduce_at(
      "BEGIN BULK\n"
      "PBUSH          1       K  17825.  12435.   7842.   8735.1000000. 204500.\n"
      "GRID           1       0      0.      0.      0.       0\n"
      "GRID           2       0     12.    25.2    37.8       0\n"
      "CBUSH          1       1       1       2.7071068.7071068      0.\n" +
          bars_ahead_of(1, 2),
      {1, 2});
  ASSERT_EQ(bush.outcome.exit_code, 0) << bush.outcome.err;
  compare("bush_01", bush.se, solve(bush.se, {{1, "123456"}}, {{2, {-1200, 300, 750, 0, 0, 0}}}), 2,
          {-2.428519, -1.060084, 1.509605, 0.07136791, -0.09476791, 0.04052213}, kMystran);
}

// SB-BAR-OFFSET: both nodes off the bar; MAT1 with a G that E and NU do not give, which twists it.
TEST_F(DeckPublished, OneBarBesideItsNodes) {
  const Reduced r = reduce_at(
      "BEGIN BULK\n"
      "GRID    101             0.      0.      0.              123456\n"
      "GRID    102             10.     0.      0.                  \n"
      "CBAR    12      10      101     102     0.      1.      0.              +CBAR1\n"
      "+CBAR1                   0.     2.0     0.0     0.0     2.0     0.0\n"
      "PBAR    10      20      .1      .1      .1      .1                      +PBAR1\n"
      "+PBAR1   1.      1.     -1.      1.     -1.     -1.      1.     -1.\n"
      "MAT1    20      1.E+7   4.E+6   .33     .1      1.                      +MAT1\n"
      "+MAT1   10000.  10000.  10000.\n"
      "ENDDATA\n",
      {101, 102});
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  EXPECT_THAT(r.outcome.out,
              HasSubstr("MAT1 20 has a G that is not E / (2 (1 + NU)): beams and rods have that G"));
  compare("SB-BAR-OFFSET", r.se, solve(r.se, {{101, "123456"}}, {{102, {200, 300, 600, 0, 0, 0}}}), 102,
          {0.04, 0.12, 0.26, -0.03, -0.03, 0.019}, kMystran);
}

// bush_07, bush_10, bush_11, bush_51: axes by a third node or a system (CID), places by OCID, nodes in one place.
TEST_F(DeckPublished, FourBushes) {
  const std::string grids =
      "GRID           1       0      0.      0.      0.       0\n"
      "GRID           2       0     12.    25.2    37.8       0\n"
      "PBUSH          1       K  17825.  12435.   7842.   8735.1000000. 204500.                \n";
  const Six force = {-1200, 300, 750, 0, 0, 0};
  const struct {
    const char* name;
    std::string cards;
    Six load, printed;
  } bushes[] = {{"bush_07",
                 grids + "GRID           3       0     15.     20.      0.       0\n"
                         "CBUSH          1       1       1       2       3                        \n",
                 force,
                 {-1.958746, -1.106083, 1.391137, 7.021336e-2, -7.700502e-2, 2.904672e-2}},
                {"bush_10",
                 grids + "GRID           3       0     15.     20.      0.       0\n"
                         "CBUSH          1       1       1       2       3                        +       \n"
                         "+                      0      8.      2.      1.\n",
                 force,
                 {-6.233524, -3.991428, 3.252802, 0.1121211, -0.1517936, 2.198956e-2}},
                {"bush_11",
                 grids + "CORD2R         3       0      0.      0.      0..3914372-.270872.8794347+       \n"
                         "+       .8794347.3914372-.270872        \n"
                         "CBUSH          1       1       1       2                               3+       \n"
                         "+                      0      5.      1.      5.\n",
                 force,
                 {-48.21241, 63.71769, -36.65486, -1.781806, -0.9153623, 0.7486954}},
                {"bush_51",
                 "PBUSH          1       K  14520.  75402.  84360. 145000.2478000.2471080.                \n"
                 "GRID           1       0      0.      0.      0.       0\n"
                 "GRID           2       0      0.      0.      0.       0\n"
                 "CBUSH          1       1       1       2                               0\n",
                 {1750, 245, 784, 0, 0, 0},
                 {0.1205234, 3.249251e-3, 9.293504e-3, 0, 0, 0}}};
  for (const auto& bush : bushes) {
    const Reduced r = reduce_at(
        "SOL 101\nCEND\n  SPC = 1\n  LOAD = 1\nBEGIN BULK\n" + bush.cards + bars_ahead_of(1, 2), {1, 2});
    ASSERT_EQ(r.outcome.exit_code, 0) << bush.name << r.outcome.err;
    compare(bush.name, r.se, solve(r.se, {{1, "123456"}}, {{2, bush.load}}), 2, bush.printed, kMystran);
  }
}

// bar_16: nodes in a system of their own, arms at both ends, shear factors.
TEST_F(DeckPublished, OneBarBesideItsNodesInATurnedSystem) {
  const Reduced r = reduce_at(
      "BEGIN BULK\n"
      "CORD2R         3       0      0.      0.      0..2511933-.122501.9601539+       \n"
      "+       .9197693.3392322-.197347        \n"
      "PBAR           1       1    184.21565.3311125.3323108.67      0.        +       \n"
      "+           -15.    -10.     15.    -10.     15.     10.    -15.     10.+       \n"
      "+       .5827076.3293826      0.\n"
      "MAT1           1  70000.26315.79     .33      0.      0.      0.        \n"
      "GRID           1       3      0.      0.      0.       0\n"
      "GRID           2       3-7.11-15    130.    200.       0\n"
      "CBAR           1       1       1       2      1.      0.      0.        +       \n"
      "+                            12.     25.     17.     12.     25.     17.\n"
      "ENDDATA\n",
      {1, 2}, kDensity);
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  compare("bar_16", r.se, solve(r.se, {{1, "123456"}}, {{2, {2500, 1750, 750, 0, 0, 0}}}), 2,
          {5.798952, 5.922279, -1.667659, -4.378023e-2, 3.982305e-2, -4.815412e-3}, kMystran);
}

// SB-BUSH-01-OFFSET-2b: the springs stand at a point of a system of their own (OCID, S1 to S3), off the line of the nodes.
TEST_F(DeckPublished, ABushAtAPointOfItsOwn) {
  const Reduced r = reduce_at(
      "BEGIN BULK\n"
      "GRID           1       0      0.      0.      0.       0\n"
      "GRID           2       0     10.      0.      0.       0\n"
      "CBUSH          1       1       1       2      0.      1.      0.        +CB1\n"
      "+CB1                  20      3.      4.      2.\n"
      "CORD2R        20       0      0.      0.      0.      1.      0.      0.+C2R\n"
      "+C2R          0.      1.      0.\n"
      "PBUSH          1       K   1000.   2000.   3000.   4000.   5000.   6000.+CP1\n"
      "+CP1                 RCV      6.      5.      4.      3.\n" +
          bars_ahead_of(1, 2),
      {1, 2});
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  compare("SB-BUSH-01-OFFSET-2b", r.se, solve(r.se, {{1, "123456"}}, {{2, {100, 200, 300, 400, 500, 600}}}),
          2, {3.19, 3.733333, 3.555, 0.075, -0.46, 0.4166667}, kMystran);
}

// case_0002: a bush along the axes of CID 0, at its end an arm (RBE2) with a mass, under a force and its own weight.
TEST_F(DeckPublished, ABushWithAnArmAndAMass) {
  const Reduced r = reduce_at(
      "BEGIN BULK\n"
      "PARAM,POST,-1\n"
      "PBUSH          1       K  17850.  24503.  57800. 170000. 270000. 370000.\n"
      "GRID           3       0     10.     20.      0.       0\n"
      "GRID           7       0     10.     20.    12.5       0\n"
      "GRID           9       0     10.     10.     50.       0\n"
      "CBUSH          3       1       3       7                               0\n"
      "RBE2           5       9  123456       7\n"
      "CONM2          6       9       0    .002      0.      0.      0.\n" +
          bars_ahead_of(3, 9),
      {3, 9});
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  const VectorXd force = solve(r.se, {{3, "123456"}}, {{9, {1780, 750, -875, 0, 0, 0}}});
  compare("case_0002, force", r.se, force, 9,
          {13.19944, 6.223164, 1.400303, -0.1415441, 0.2884259, 0.04810811}, kMystran);
  const VectorXd weight = solve(r.se, {{3, "123456"}}, {{9, {0.002 * 9827, 0, 0, 0, 0, 0}}});
  compare("case_0002, weight", r.se, weight, 9, {0.1457425, 0, 0, 0, 0.003184676, 0.0005311892}, kMystran);
}

// SB-RBE3-01-CBAR-08: a mean motion that carries nothing but a load.
TEST_F(DeckPublished, AFrameUnderAMeanMotion) {
  const Reduced r = reduce_at(
      "BEGIN BULK\n"
      "SPC1    1       123456  100     108     116     124\n"
      "GRID     100              2.      2.      0.\n"
      "GRID     108             -2.      2.      0.\n"
      "GRID     116             -2.     -2.      0.\n"
      "GRID     124              2.     -2.      0.\n"
      "GRID    1000              2.      2.      5.\n"
      "GRID    1008             -2.      2.      5.\n"
      "GRID    1016             -2.     -2.      5.\n"
      "GRID    1024              2.     -2.      5.\n"
      "GRID    9999              0.      0.     10.\n"
      "RBE3    9999            9999    123456  1.      123     1000    1008    +\n"
      "+       1016    1024\n"
      "CBAR    11      10      100     1000    1.      0.      0.\n"
      "CBAR    12      10      108     1008    1.      0.      0.\n"
      "CBAR    13      10      116     1016    1.      0.      0.\n"
      "CBAR    14      10      124     1024    1.      0.      0.\n"
      "CBAR    21      10      1000    1008    0.      0.      1.\n"
      "CBAR    22      10      1008    1016    0.      0.      1.\n"
      "CBAR    23      10      1016    1024    0.      0.      1.\n"
      "CBAR    24      10      1024    1000    0.      0.      1.\n"
      "CONM2   99      1000            1.\n"
      "PBAR    10      20      1.      1.      1.      1.\n"
      "MAT1    20      10.+6   4.+6                                            +\n"
      "+       10000.  10000.  10000.\n"
      "ENDDATA\n",
      {100, 108, 116, 124, 9999}, "[material.20]\ndensity = 0.1\n");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  const std::map<int, std::string> held = {
      {100, "123456"}, {108, "123456"}, {116, "123456"}, {124, "123456"}};
  compare("SB-RBE3-01-CBAR-08, shear", r.se, solve(r.se, held, {{9999, {0, 1e5, 0, 0, 0, 0}}}), 9999,
          {0, 0.1681727, 0, -1.844880e-2, 0, 0}, kMystran);
}

// SB-RBE2-02-CBAR-03: two ties of the directions 1, 2 and 6 alone make the outer bars rigid in their plane; the other directions
// are held by GRDSET.  Bending of the first bar by force and moment; the printed digits are these exact ones.
TEST_F(DeckPublished, BarsMadeRigidInTheirPlane) {
  const Reduced r = reduce_at(
      "BEGIN BULK\n"
      "SPC1    123     126     101\n"
      "GRDSET                                                  345\n"
      "GRID    101               0.    0.      0.\n"
      "GRID    102              10.    0.      0.\n"
      "GRID    103              20.    0.      0.\n"
      "GRID    113             120.    0.      0.\n"
      "CBAR    20102   20      101     102     0.      1.      0.\n"
      "CBAR    20203   20      102     103     0.      1.      0.\n"
      "CBAR    20313   20      103     113     0.      1.      0.\n"
      "PBAR    20      10      .01     .1      .1      .1\n"
      "MAT1    10      1.+7            .33     .1      1.                      +MAT1\n"
      "RBE2    30203   103     126     102\n"
      "RBE2    30713   103     126     113\n"
      "ENDDATA\n",
      {101, 113});
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  const VectorXd u = solve(r.se, {{101, "123456"}, {113, "345"}}, {{113, {1000, 3, 0, 0, 0, 0}}});
  compare("SB-RBE2-02-CBAR-03", r.se, u, 113, {0.1, 0.397, 0, 0, 0, 3.45e-3}, kMystran);
}

// "NAS S30 beam section shapes no shear": nine columns in one deck, MSC Nastran's digits.  Reals without an E in wide fields.
TEST_F(DeckPublished, NineColumnsOfMsc) {
  struct Column {
    int tip, root, x;
    const char* property;
    Six printed;
  };
  const std::vector<Column> columns = {
      {2,
       1,
       0,
       "2.8-3 4.49333333333-6*\n*        2.83047619048-6 8.96714727368-8",
       {-1.656082e-5, 6.954748e-6, 2.777778e-8, 5.563798e-6, 1.324865e-5, 2.787955e-4}},
      {6,
       5,
       3,
       "2.0-3 2.35416666667-6*\n*        8.41666666667-7 6.71787940885-8",
       {-5.569307e-5, 1.327434e-5, 3.888889e-8, 1.061947e-5, 4.455446e-5, 3.721412e-4}},
      {10,
       9,
       6,
       "2.9-3 1.30735254169-5*\n*        1.37825619231-6 9.48354730769-8",
       {-3.401037e-5, 2.390327e-6, 2.681992e-8, 1.912262e-6, 2.720829e-5, 2.636144e-4}},
      {14,
       13,
       9,
       "3.8-3 2.29266666667-5*\n*        1.68166666667-6 1.29790920417-7",
       {-2.787413e-5, 1.363042e-6, 2.046784e-8, 1.090433e-6, 2.229931e-5, 1.926175e-4}},
      {18,
       17,
       12,
       "3.0-2         5.625-5*\n*                  1.0-4 1.21490661621-4",
       {-4.687500e-7, 5.555556e-7, 2.592593e-9, 4.444444e-7, 3.75e-7, 2.057771e-7}},
      {8,
       7,
       15,
       "9.6-3        1.2072-4*\n*                6.392-5 1.26500416667-4",
       {-7.333385e-7, 2.588635e-7, 8.101852e-9, 2.070908e-7, 5.866708e-7, 1.976278e-7}},
      {4,
       3,
       18,
       "3.14159265359-2 7.85398163397-5*\n*        7.85398163397-5 1.57079632679-4",
       {-5.968310e-7, 3.978874e-7, 2.475744e-9, 3.183099e-7, 4.774648e-7, 1.591549e-7}},
      {16,
       12,
       21,
       "4.71238898038-3 2.00276531666-6*\n*        2.00276531666-6 4.00553063333-6",
       {-2.340514e-5, 1.560343e-5, 1.650496e-8, 1.248274e-5, 1.872411e-5, 6.241370e-6}},
      {11,
       15,
       24,
       "3.0-2           1.0-4*\n*                5.625-5 1.21490661621-4",
       {-8.333333e-7, 3.125e-7, 2.592593e-9, 2.5e-7, 6.666667e-7, 2.057771e-7}}};
  int k = 0;
  for (const Column& c : columns) {
    ++k;
    std::string area = c.property;
    area.insert(0, 16 - area.find_first_of(' '), ' ');
    const std::string x = fmt::format("{}.0+0", c.x);
    const Reduced r =
        reduce_at("SOL 101\nCEND\nBEGIN BULK\n" +
                      fmt::format("GRID    {:8}       0{:>8}   0.0+0   2.5+0       0\n", c.root, x) +
                      fmt::format("GRID    {:8}       0{:>8}   0.0+0   0.0+0       0\n", c.tip, x) +
                      fmt::format("MAT1    {:8}  2.0+11  1.0+11   0.0+0   1.0+3   0.0+0   0.0+0\n", k) +
                      fmt::format("PBAR*   {:16}{:16}{}           0.0+0\n", k, k, area) +
                      fmt::format("CBAR    {:8}{:8}{:8}{:8}   0.0+0   1.0+0   0.0+0        \nENDDATA \n", k,
                                  k, c.tip, c.root),
                  {c.tip, c.root});
    ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    compare("nine columns", r.se,
            solve(r.se, {{c.root, "123456"}}, {{c.tip, {0, 0, 6.22222222222, 2, 3, 1}}}), c.tip, c.printed,
            "MSC Nastran 2024.2 in MYSTRAN's validation (MIT)");
  }
}

}  // namespace
}  // namespace flexura::test
