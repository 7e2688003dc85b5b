// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What a deck ties: surfaces, equations, spiders of several elements.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "tests/found/parts.hpp"

namespace flexura::test {
namespace {

using Eigen::VectorXd;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

using DeckTies = Parts;

// Two blocks that *TIE joins are the block of two elements; where no nodes meet they stay apart, which is said, as are
// keywords that bind and are not read.
TEST_F(DeckTies, AbaqusTiesJoinNodesThatMeet) {
  const auto deck = [](double y, const char* joint, int second) {
    std::string text = "*HEADING\n*NODE\n";
    int label = 0;
    for (const double x : {0.0, 0.1, 0.1, 0.2})
      for (const auto& [u, v] : {std::pair(0.0, 0.0), {0.1, 0.0}, {0.1, 0.1}, {0.0, 0.1}}) {
        ++label;
        text += fmt::format("{}, {:.6f}, {:.6f}, {}\n", label, x, u + (label > 8 ? y : 0.0), v);
      }
    return text +
           fmt::format(
               "*ELEMENT, TYPE=C3D8, ELSET=A\n1, 1,2,3,4, 5,6,7,8\n*ELEMENT, TYPE=C3D8, ELSET=B\n2, "
               "{0},{1},{2},{3}, "
               "13,14,15,16\n*ELSET, ELSET=ALL\n1, 2\n*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n*MATERIAL, "
               "NAME=STEEL\n*ELASTIC\n2.1E11, 0.3\n*DENSITY\n7850.\n*SURFACE, NAME=LEFT\nA, S2\n*SURFACE, "
               "NAME=RIGHT\nB, S1\n",
               second, second + 1, second + 2, second + 3) +
           joint;
  };
  const std::string foot =
      "unit = \"m\"\n[interface.foot]\nby = \"nodes\"\nnodes = [1, 2, 3, 4]\n[interface.tip]\nby = "
      "\"nodes\"\nnodes = [13, 14, 15, 16]\n[modes]\ncount = 2\n";
  // Meshes as coarse as these do not replace finer ones: each is written anew.
  const auto reduced = [&](const std::string& text) {
    std::filesystem::remove(folder_ / "part.se.h5");
    return reduce_deck(text, foot, {}, "deck.inp");
  };
  const Reduced whole = reduced(deck(0.0, "", 5)),
                tied = reduced(deck(1e-4, "*TIE, NAME=T\nRIGHT, LEFT\n", 9));
  ASSERT_EQ(whole.outcome.exit_code, 0) << whole.outcome.err;
  ASSERT_EQ(tied.outcome.exit_code, 0) << tied.outcome.err;
  EXPECT_THAT(tied.outcome.out, HasSubstr("4 nodes of RIGHT are joined to nodes of LEFT"));
  EXPECT_THAT(tied.outcome.err, Not(HasSubstr("*TIE")));
  // 0.1 mm of 100 mm: the second block stands askew by so much.
  for (int k = 0; k < 2; ++k)  // (equal ones of the straight bar are kept together)
    EXPECT_NEAR(tied.se.omega2(k) / whole.se.omega2(k), 1.0, 1e-2);
  // Shifted along the joint the nodes meet faces, those within reach; two of them are a hinge, and the others are told.
  const Reduced apart = reduced(deck(0.04, "*TIE, NAME=T\nRIGHT, LEFT\n", 9));
  EXPECT_EQ(apart.outcome.exit_code, 0) << apart.outcome.out;
  EXPECT_THAT(apart.outcome.err,
              HasSubstr("2 of the nodes of RIGHT lie farther than 0.005 from LEFT and stay apart"));
  const Reduced bound = reduced(deck(0.0, "*EMBEDDED ELEMENT\nB\n*MPC\nSLIDER, 6, 7, 8\n", 5));
  ASSERT_EQ(bound.outcome.exit_code, 0) << bound.outcome.err;
  EXPECT_THAT(bound.outcome.err,
              AllOf(HasSubstr("warning: 1 keyword *EMBEDDED ELEMENT is not used"),
                    HasSubstr("*MPC of type SLIDER"), HasSubstr("what it binds stays apart")));
  EXPECT_THAT(bound.outcome.out, HasSubstr("with care: "));
}

// A block of bricks, n by n across and one along, with numbers from `first`; its ends are the surfaces NAME-LOW, NAME-HIGH.
std::string block(const std::string& name, double x0, double x1, int n, int first) {
  std::string text = "*NODE\n";
  const auto node = [&](int i, int j, int k) { return first + i * (n + 1) * (n + 1) + j * (n + 1) + k; };
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j <= n; ++j)
      for (int k = 0; k <= n; ++k)
        text += fmt::format("{}, {}, {:.17g}, {:.17g}\n", node(i, j, k), i == 0 ? x0 : x1, 0.1 * j / n,
                            0.1 * k / n);
  text += "*ELEMENT, TYPE=C3D8, ELSET=" + name + "\n";
  for (int j = 0; j < n; ++j)
    for (int k = 0; k < n; ++k)
      text += fmt::format("{}, {},{},{},{}, {},{},{},{}\n", first + j * n + k, node(0, j, k),
                          node(0, j + 1, k), node(0, j + 1, k + 1), node(0, j, k + 1), node(1, j, k),
                          node(1, j + 1, k), node(1, j + 1, k + 1), node(1, j, k + 1));
  return text + fmt::format(
                    "*SOLID SECTION, ELSET={0}, MATERIAL=STEEL\n*SURFACE, NAME={0}-LOW\n{0}, S1\n*SURFACE, "
                    "NAME={0}-HIGH\n{0}, "
                    "S2\n",
                    name);
}
const std::string kSteel = "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.E11, 0.3\n*DENSITY\n7850.\n";
const std::string kMeanEnds =
    "unit = \"m\"\n[interface.foot]\nby = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\ntie = "
    "\"average\"\n"
    "[interface.tip]\nby = \"plane\"\npoint = [0.2, 0, 0]\nnormal = [1, 0, 0]\ntie = "
    "\"average\"\n[modes]\ncount = 2\n";

// Tension of two blocks whose meshes do not match.  Nodes that follow faces pass a uniform stress on exactly where the
// follower's mesh divides the master's faces; otherwise displacements are continuous at the nodes alone, and the joint is
// stiffer or softer by what it lets through of one element's length.
TEST_F(DeckTies, TiedBlocksOfOtherMeshesPassTensionOn) {
  const auto compliance = [&](int master, int slave) {
    const Reduced r =
        reduce_deck("*HEADING\n" + block("A", 0.0, 0.1, master, 1) + block("B", 0.1, 0.2, slave, 1000) +
                        kSteel + "*TIE, NAME=T\nB-LOW, A-HIGH\n",
                    kMeanEnds, {}, "deck.inp");
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    if (r.outcome.exit_code != 0) return 0.0;
    EXPECT_THAT(r.outcome.out,
                AllOf(HasSubstr("follow the faces of A-HIGH"), HasSubstr("mesh error: unknown")));
    EXPECT_EQ(r.outcome.err.find("*TIE"), std::string::npos) << r.outcome.err;
    VectorXd load = VectorXd::Zero(6);
    load(0) = 1.0;
    return statics(r.se, 0, 1, load)(r.se.interfaces[1].first_dof) * 2e11 * 0.01 / 0.2;
  };
  EXPECT_NEAR(compliance(1, 2), 1.0, 1e-9);
  EXPECT_NEAR(compliance(1, 3), 1.0, 1e-9);
  EXPECT_NEAR(compliance(2, 4), 1.0, 1e-9);
  EXPECT_NEAR(compliance(2, 3), 1.0, 0.01);
  EXPECT_NEAR(compliance(3, 2), 1.0, 0.03);
}

// The same in instances of parts, whose surfaces are named INSTANCE.SURFACE; sets of the assembly that go over two instances.
TEST_F(DeckTies, SurfacesAndSetsOfInstances) {
  const std::string deck =
      "*HEADING\n*PART, NAME=COARSE\n" + block("E", 0.0, 0.1, 1, 1) + "*END PART\n*PART, NAME=FINE\n" +
      block("E", 0.0, 0.1, 2, 1) +
      "*END PART\n*ASSEMBLY, NAME=WHOLE\n*INSTANCE, NAME=left, PART=COARSE\n*END INSTANCE\n"
      "*INSTANCE, NAME=right, PART=FINE\n0.1, 0., 0.\n*END INSTANCE\n"
      "*ELSET, ELSET=BOTH, INSTANCE=left\n1\n*ELSET, ELSET=BOTH, INSTANCE=right\nE\n"
      "*NSET, NSET=ENDS, INSTANCE=left, GENERATE\n1, 4\n*NSET, NSET=ENDS, INSTANCE=right, GENERATE\n10, 18\n"
      "*NSET, NSET=ALSO\nENDS\n"
      "*TIE, NAME=T\nright.E-LOW, left.E-HIGH\n*END ASSEMBLY\n" +
      kSteel;
  const Reduced r = reduce_deck(deck, kMeanEnds, {}, "deck.inp");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  VectorXd load = VectorXd::Zero(6);
  load(0) = 1.0;
  EXPECT_NEAR(statics(r.se, 0, 1, load)(r.se.interfaces[1].first_dof) * 2e11 * 0.01 / 0.2, 1.0, 1e-9);
  // The ends by the set of a set: one rigid interface of 4 + 9 nodes.
  const Reduced ends = reduce_deck(
      deck, "unit = \"m\"\n[interface.ends]\nby = \"group\"\ngroup = \"ALSO\"\n[modes]\ncount = 2\n", {},
      "deck.inp");
  ASSERT_EQ(ends.outcome.exit_code, 0) << ends.outcome.err;
  EXPECT_THAT(ends.outcome.out, HasSubstr("13 nodes"));
  EXPECT_LT((ends.se.interfaces[0].p_BoN_B - Eigen::Vector3d(0.2 * 9 / 13, 0.05, 0.05)).norm(), 0.05);
}

// A beam from 1 to 2, and a bar hinged to its middle, of which u(5) = (u(1) + u(2)) / 2 is all that is said: by hand,
// EA/l between 6 and the mean of 1 and 2.
void expect_hinged_bar(const superelement::Superelement& se) {
  const double E = 2e11, A = 0.02 * 0.02, l = 0.4, I = 0.02 * 0.02 * 0.02 * 0.02 / 12, G = E / 2.6, L = 1.0;
  const double k = E * A / l,
               phi = 12 * E * I / (G * A * 0.85 * L * L);  // shear factor 0.85 of *BEAM SECTION, RECT
  const auto at = [&](int i, int j) {
    return se.K_se(se.interfaces[i].first_dof + 1, se.interfaces[j].first_dof + 1);
  };
  EXPECT_NEAR(at(2, 2) / k, 1.0, 1e-9);
  EXPECT_NEAR(at(2, 0) / k, -0.5, 1e-9);
  EXPECT_NEAR(at(2, 1) / k, -0.5, 1e-9);
  EXPECT_NEAR(at(0, 1) / k, 0.25 - 12 * E * I / (L * L * L * (1 + phi)) / k, 1e-3 * 12 * E * I / k);
}
const std::string kThree =
    "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\nnodes = "
    "[2]\n[interface.c]\nby = "
    "\"nodes\"\nnodes = [6]\n[modes]\ncount = 1\n";

TEST_F(DeckTies, EquationsBindDofs) {
  const std::string deck =
      "*HEADING\n*NODE\n1, 0,0,0\n2, 1,0,0\n5, .5,0,0\n6, .5,.4,0\n*ELEMENT, TYPE=B31, ELSET=B\n1, 1,2\n2, "
      "5,6\n"
      "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=RECT\n.02,.02\n0.,0.,1.\n*NSET, NSET=MID\n5\n" +
      kSteel;
  const std::string bound =
      "*EQUATION\n3\nMID,1,-1., 1,1,.5, 2,1,.5\n3\n5,2,-1., 1,2,.5,\n2,2,.5\n3\n5,3,-1.,1,3,.5,2,3,.5\n";
  const Reduced r = reduce_deck(deck + bound, "unit = \"m\"\n" + kThree, {}, "deck.inp");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  expect_hinged_bar(r.se);
  EXPECT_THAT(r.outcome.out, HasSubstr("3 equations between dofs"));
  // Dofs in axes of their own: 1 of node 5 is y.
  const Reduced turned = reduce_deck(
      deck + "*TRANSFORM, NSET=MID\n0.,1.,0., -1.,0.,0.\n" +
          "*EQUATION\n3\n5,2,1., 1,1,.5, 2,1,.5\n3\n5,1,-1., 1,2,.5, 2,2,.5\n3\n5,3,-1., 1,3,.5, 2,3,.5\n",
      "unit = \"m\"\n" + kThree, {}, "deck.inp");
  ASSERT_EQ(turned.outcome.exit_code, 0) << turned.outcome.err;
  expect_hinged_bar(turned.se);
  const auto refusal = [&](const std::string& equation) {
    const Reduced bad = reduce_deck(deck + equation, "unit = \"m\"\n" + kThree, {}, "deck.inp");
    EXPECT_EQ(bad.outcome.exit_code, 2) << equation;
    return bad.outcome.err;
  };
  EXPECT_THAT(refusal("*EQUATION\n2\n5, 1, 1., 1\n"), HasSubstr("has 4 entries instead of 6"));
  EXPECT_THAT(refusal("*EQUATION\n2\n5, 8, 1., 1, 8, -1.\n"), HasSubstr("names dof 8"));
  EXPECT_THAT(refusal("*EQUATION\n2\nNONE, 1, 1., 1, 1, -1.\n"), HasSubstr("is no node and no set"));
}

TEST_F(DeckTies, NastranEquationsAreChosenAndFollowDisplacementAxes) {
  const auto deck = [](const std::string& control, const std::string& mpc) {
    return control +
           "BEGIN "
           "BULK\nMAT1,1,2.+11,,0.3,7850.\nPBARL,1,1,,BAR,,,,,.02,.02\nCORD2R,9,,0.,0.,0.,0.,0.,1.\n,0.,1.,0."
           "\n"
           "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,5,,.5,0.,0.,9\nGRID,6,,.5,.4,0.\nCBAR,1,1,1,2,0.,0.,1.\n"
           "CBAR,2,1,5,6,0.,0.,1.\n" +
           mpc + "ENDDATA\n";
  };
  // 1 of grid 5 is y, 2 is -x.
  const std::string one = "MPC,3,5,1,-1.,1,2,.5\n,,2,2,.5\n",
                    two = "MPC,4,5,2,1.,1,1,.5\n,,2,1,.5\nMPC,4,5,3,-1.,1,3,.5\n,,2,3,.5\n",
                    other = "MPC,8,5,1,-1.,6,2,1.\n";
  for (const std::string& text : {deck("", one + two + "MPCADD,7,3,4\n"),
                                  deck("SOL 101\nCEND\nMPC = 7\n", one + two + other + "MPCADD,7,3,4\n")}) {
    const Reduced r = reduce_deck(text, kThree);
    ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    expect_hinged_bar(r.se);
  }
  const Reduced open = reduce_deck(deck("", one + two), kThree);
  EXPECT_EQ(open.outcome.exit_code, 2);
  EXPECT_THAT(open.outcome.err, HasSubstr("no case control says which holds"));
  const Reduced spline =
      reduce_deck(deck("", one + two + "MPCADD,7,3,4\nRSPLINE,50,,1,2,123456,5\n"), kThree);
  EXPECT_THAT(spline.outcome.err, HasSubstr("1 card RSPLINE is not used"));
}

}  // namespace
}  // namespace flexura::test
