// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Decks of several kinds of elements, of other projects, against the displacements that these publish.  Their shells and
// solids are of other kinds than ours: what coarse meshes of them share is a matter of per cents, not of digits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <map>
#include <string>
#include <vector>

#include "tests/found/decks/published.hpp"

namespace flexura::test {
namespace {

using Eigen::VectorXd;
using testing::HasSubstr;

class DeckMixed : public DeckPublished {
 protected:
  static std::string file(const std::string& name) {
    return read_text(FLEXURA_SOURCE_DIR "/tests/found/decks/" + name);
  }
};

// SB-ALL-ELEM-TEST: a shelf of shells and bars hung on rods, under pressure (as MYSTRAN prints its forces).  The spring to the
// ground below its middle is none of the body.
TEST_F(DeckMixed, MystransShelf) {
  const std::vector<int> nodes = {1011, 1012, 1013, 1021, 1022, 1023, 1031, 1032, 1033, 1041, 1042, 1043};
  Reduced r = reduce_at(file("SB-ALL-ELEM-TEST.DAT"), nodes);
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  r.se.K_se(first(r.se, 1022) + 2, first(r.se, 1022) + 2) += 1.5e4;
  const VectorXd u = solve(
      r.se, {{1011, "123"}, {1012, "123"}, {1013, "123"}, {1041, "12456"}, {1042, "12456"}, {1043, "12456"}},
      {{1011, {0, 0, -468.75, -3906.25, 3906.25, 0}},
       {1012, {0, 0, -937.5, -7812.5, 0, 0}},
       {1013, {0, 0, -468.75, -3906.25, -3906.25, 0}},
       {1021, {0, 0, -1093.75, -1953.125, 9765.625, 0}},
       {1022, {0, 0, -1562.5, 3906.25, 0, 0}},
       {1023, {0, 0, -1093.75, -1953.125, -9765.625, 0}},
       {1031, {0, 0, -312.5, 1953.125, 1953.125, 0}},
       {1032, {0, 0, -1250, 11718.75, 0, 0}},
       {1033, {0, 0, -312.5, 1953.125, -1953.125, 0}}});
  const std::map<int, double> printed = {{1021, -2.338150e-1}, {1022, -1.703534e-1}, {1023, -2.338150e-1},
                                         {1032, -7.707326e-2}, {1041, -3.262529e-3}, {1042, -5.836688e-3}};
  for (const auto& [node, value] : printed)
    expect_reference(
        fmt::format("SB-ALL-ELEM-TEST, node {}, u_z", node), "in", u(first(r.se, node) + 2), value,
        0.003 * std::abs(value),
        {"MYSTRAN's validation (MIT)", "0.3 %: its shells are of another kind, in a mesh of 2 x 2"});
}

// pyNastran's models/beam_modes (SteveDoyle2/pyNastran, BSD licence): PBARL and PBEAML in a file of their own, a mass at the tip; mass and
// frequencies that MSC Nastran 2005 prints, with its lumped masses on ten elements.
TEST_F(DeckMixed, PynastransBeamModes) {
  std::string bars;
  for (int k = 1; k <= 11; ++k)
    bars += fmt::format("GRID    {:8}       0{:8.5f}     0.0     0.0       0\n", k, k - 1.0);
  bars += "GRID          12       0 5.49607     0.0     0.0       0\n$*  ELEMENT CARDS\n$*\n";
  for (int k = 1; k <= 9; ++k)
    bars += fmt::format("CBAR    {:8}       1{:8}{:8}     0.01.000000     0.0\n", k, k, k + 1);
  folder_.write("cbar_cbeam.blk",
                bars +
                    "CBEAM         10       3      10      11     0.01.000000     0.0\n"
                    "CONM2         21      11       02.5900-3     0.0     0.0     0.0        + \n"
                    "+       2.5900-3     0.02.5900-3     0.0     0.02.5900-3\n"
                    "MAT1           23.0000+71.1628+7.29000007.4851-4     0.0             0.0\n"
                    "PBARL          1       2MSCBML0 ROD                                     + \n"
                    "+       1.000000     0.0\n"
                    "PBEAML         3       2MSCBML0 ROD                                     + \n"
                    "+       1.000000     0.0\n");
  const Reduced r = reduce_deck(
      "SOL SEMODES\n$*\nCEND\nMETHOD = 1\nOUTPUT(XYPLOT)\nXYPRINT DISP / 1(T2), 2(T2) \nBEGIN BULK\n"
      "PARAM   K6ROT   100.0000\nEIGRL          1                      10                             "
      "MAX\n$*\n"
      "INCLUDE 'cbar_cbeam.blk'\n$*\nSPC            1       1  123456     0.0\nENDDATA\n",
      "[interface.root]\nby = \"nodes\"\nnodes = [1]\n[modes]\ncount = 8\n", {}, "beam_modes.dat");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  EXPECT_THAT(r.outcome.out, HasSubstr("1 node belongs to no element and is left out"));
  const Reference digits = {"MSC Nastran 2005 in pyNastran's models (BSD)", "the last digit printed"};
  expect_reference("beam_modes, mass", "", r.se.inertia.mass, 2.610514e-2, 0.51e-8, digits);
  expect_reference("beam_modes, first moment", "", r.se.inertia.S_x.x(), 1.434757e-1, 0.51e-7, digits);
  const Reference lumped = {"MSC Nastran 2005 in pyNastran's models (BSD)",
                            "0.5 %: lumped masses on ten elements"};
  const VectorXd hz = clamped_hz(r.se);
  expect_reference("beam_modes, bending", "Hz", hz(0), 456.6603, 0.005 * 456.6603, lumped);
  expect_reference("beam_modes, stretch", "Hz", hz(5), 4507.487, 0.005 * 4507.487, lumped);
}

}  // namespace
}  // namespace flexura::test
