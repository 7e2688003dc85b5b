// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Decks of beams, rods, springs and point masses, from the file to the superelement: against exact solutions.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "mbs/superelement/modes.hpp"
#include "tests/found/decks/plate_deck.hpp"
#include "tests/found/parts.hpp"

namespace flexura::test {
namespace {

using Eigen::VectorXd;
using testing::AllOf;
using testing::HasSubstr;
constexpr double kPi = std::numbers::pi;

using DeckBeams = Parts;

const std::string kBeamDeck =
    "BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\nPBARL,1,1,,BAR\n,0.03,0.05\n"  // 30 mm along z, 50 mm along y
    "{}ENDDATA\n";

// n CBARs along x of length 1.
std::string cantilever(int n, const std::string& more = "") {
  std::string text;
  for (int k = 0; k <= n; ++k) text += fmt::format("GRID,{},,{:.15g},0.,0.\n", k + 1, 1.0 * k / n);
  for (int k = 0; k < n; ++k) text += fmt::format("CBAR,{},1,{},{},0.,1.,0.\n", k + 1, k + 1, k + 2);
  return fmt::format(fmt::runtime(kBeamDeck), text + more);
}

TEST_F(DeckBeams, BeamsOfADeckAreTimoshenkosToTheLastDigits) {
  const std::string ends =
      "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\nnodes = [5]\n";
  const Reduced r = reduce_deck(cantilever(4), ends + "[modes]\ncount = 6\n");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  const double E = 2.1e11, G = E / 2.6, A = 0.0015, I_zz = 0.03 * std::pow(0.05, 3) / 12,
               I_yy = 0.05 * std::pow(0.03, 3) / 12;
  const auto tip = [&](int d) {
    VectorXd load = VectorXd::Zero(6);
    load(d) = 1.0;
    return statics(r.se, 0, 1, load)(r.se.interfaces[1].first_dof + d);
  };
  EXPECT_NEAR(tip(0) * E * A, 1.0, 1e-9);
  EXPECT_NEAR(tip(1) / (1 / (3 * E * I_zz) + 1.2 / (G * A)), 1.0, 1e-9);
  EXPECT_NEAR(tip(2) / (1 / (3 * E * I_yy) + 1.2 / (G * A)), 1.0, 1e-9);
  // Saint-Venant's constant of 50 x 30: 0.2129 a b^3 (Timoshenko, Goodier, table of art. 109: 0.2137 at 5/3 by
  // interpolation of 0.196 at 1.5 and 0.229 at 2: 1 %).
  EXPECT_NEAR(1 / (tip(3) * G * 0.05 * std::pow(0.03, 3)), 0.208, 0.006);
  // Inertia of the solid bar.
  const double m = 7850 * A;
  EXPECT_NEAR(r.se.inertia.mass, m, 1e-12 * m);
  Eigen::Matrix3d S_xx = Eigen::Vector3d(1.0 / 3, 0.05 * 0.05 / 12, 0.03 * 0.03 / 12).asDiagonal();
  EXPECT_LT((r.se.inertia.S_xx / m - S_xx).norm(), 1e-12);
}

// The first frequencies of a clamped-clamped bar, 22.3733 and 61.6728 sqrt(EI / rho A) / l^2, without shear and rotary
// inertia's 2 % and 6 %: slender enough (l / radius of gyration 400) for 3e-4.
TEST_F(DeckBeams, BeamsOfADeckVibrateAsBeamsDo) {
  std::string text =
      "BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\nPBAR,1,1,7.853982-5,4.908739-10,4.908739-10,9.817477-10\n";
  for (int k = 0; k <= 12; ++k) text += fmt::format("GRID,{},,0.,{:.15g},0.\n", k + 1, k / 12.0);
  for (int k = 0; k < 12; ++k) text += fmt::format("CBAR,{},1,{},{},1.,0.,0.\n", k + 1, k + 1, k + 2);
  const Reduced r = reduce_deck(text + "ENDDATA\n",
                                "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\n"
                                "nodes = [13]\n[modes]\ncount = 4\n");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  const double scale = std::sqrt(2.1e11 * 4.908739e-10 / (7850 * 7.853982e-5)) / (2 * kPi);
  const VectorXd hz = clamped_hz(r.se);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(hz(k) / (scale * (k < 2 ? 22.37329 : 61.67282)), 1.0, 1e-3) << k;
}

// Two bars that meet in a bushing or in scalar springs: compliances add.
TEST_F(DeckBeams, SpringsOfADeckAddTheirCompliance) {
  const double E = 2.1e11, A = 0.0015, k = 3e7;
  const std::string bars =
      "GRID,1,,0.,0.,0.\nGRID,2,,0.5,0.,0.\nGRID,3,,0.5,0.,0.\nGRID,4,,1.,0.,0.\n"
      "CBAR,1,1,1,2,0.,1.,0.\nCBAR,2,1,3,4,0.,1.,0.\n";
  const std::string bush = "PBUSH,7,K,3.+7,2.+7,1.+7,1.+5,2.+5,3.+5\nCBUSH,10,7,2,3,,,,0\n";
  std::string scalar = "PELAS,9,3.+7\nCELAS1,10,9,2,1,3,1\n";
  for (int c = 2; c <= 6; ++c)
    scalar += fmt::format("CELAS2,{},{},2,{},3,{}\n", 10 + c, c < 4 ? "2.+7" : "1.+5", c, c);
  for (const std::string& springs : {bush, scalar}) {
    const Reduced r =
        reduce_deck(fmt::format(fmt::runtime(kBeamDeck), bars + springs),
                    "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\nnodes = [4]\n"
                    "[modes]\ncount = 2\n");
    ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    VectorXd load = VectorXd::Zero(6);
    load(0) = 1.0;
    EXPECT_NEAR(statics(r.se, 0, 1, load)(r.se.interfaces[1].first_dof) / (1 / (E * A) + 1 / k), 1.0, 1e-9);
  }
}

// The same structure for Abaqus: beams with their section by shape, a truss, a spring, a mass with moments of inertia, a
// coupling to a surface of solids.
TEST_F(DeckBeams, AbaqusBeamsMassesAndCouplings) {
  const std::string deck =
      "*HEADING\n*NODE\n1,0.,0.,0.\n2,.1,0.,0.\n3,.1,.1,0.\n4,0.,.1,0.\n5,0.,0.,.1\n6,.1,0.,.1\n7,.1,.1,."
      "1\n8,0.,.1,.1\n"
      "20,.1,.05,.05\n21,.6,.05,.05\n22,.6,.05,.3\n"
      "*ELEMENT, TYPE=C3D8, ELSET=BLOCK\n1,1,2,3,4,5,6,7,8\n*ELEMENT, TYPE=B31, "
      "ELSET=BEAM\n2,20,21\n3,21,22\n"
      "*ELEMENT, TYPE=T3D2, ELSET=STAY\n4,20,22\n*ELEMENT, TYPE=MASS, ELSET=LUMP\n5,22\n*ELEMENT, "
      "TYPE=ROTARYI, ELSET=TURN\n6,22\n"
      "*SOLID SECTION, ELSET=BLOCK, MATERIAL=STEEL\n*SOLID SECTION, ELSET=STAY, MATERIAL=STEEL\n1.E-4\n"
      "*BEAM SECTION, ELSET=BEAM, MATERIAL=STEEL, SECTION=RECT\n0.02, 0.04\n0.,1.,0.\n*MASS, ELSET=LUMP\n3.\n"
      "*ROTARY INERTIA, ELSET=TURN\n.1,.2,.15,0.,0.,0.\n*MATERIAL, "
      "NAME=STEEL\n*ELASTIC\n2.1E11,0.3\n*DENSITY\n7850.\n"
      "*SURFACE, NAME=FACE, TYPE=ELEMENT\nBLOCK, S4\n*COUPLING, CONSTRAINT NAME=C1, REF NODE=20, "
      "SURFACE=FACE\n*KINEMATIC\n";
  const Reduced r =
      reduce_deck(deck,
                  "unit = \"m\"\n[interface.foot]\nby = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\n"
                  "[interface.knee]\nby = \"nodes\"\nnodes = [21]\n[modes]\ncount = 4\n",
                  {}, "deck.inp");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  const double stay = std::hypot(0.5, 0.25);
  EXPECT_NEAR(r.se.inertia.mass, 7850 * (0.001 + 0.75 * 8e-4 + stay * 1e-4) + 3.0, 1e-9);
  EXPECT_THAT(r.outcome.out, AllOf(HasSubstr("3 beams and rods"), HasSubstr("*COUPLING")));
  const Reduced bare = reduce_deck(
      replaced(deck, "*BEAM SECTION, ELSET=BEAM, MATERIAL=STEEL, SECTION=RECT\n0.02, 0.04\n0.,1.,0.\n", ""),
      "unit = \"m\"\n", {}, "deck.inp");
  EXPECT_EQ(bare.outcome.exit_code, 2);
  EXPECT_THAT(bare.outcome.err, HasSubstr("has no section"));
}

// A beam under forces and moments at its end, at each corner of its cross-section: N/A and both bendings, those of sections with
// a product of inertia, too (the corner of an L); by shapes and by C1 to F2 of PBAR and PBEAM.
TEST_F(DeckBeams, StressesOfBeamsAreThoseOfForceAndBending) {
  const std::string rest =
      "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\nnodes = [5]\n"
      "[modes]\ncount = 2\n[recovery]\nstress = true\n";
  struct Case {
    const char *kind, *property;
    double A, I_yy, I_zz, I_yz, y, z;  // y, z: of the axis from the centroid
    std::size_t points;
  };
  // L: legs 60 x 10 along y (upright) and 40 x 10 along z (lying); its middle lines by hand.
  const double A1 = 40 * 10, A2 = 50 * 10, yc = (A1 * 5 + A2 * 35) / (A1 + A2),
               zc = (A1 * 20 + A2 * 5) / (A1 + A2);
  const double L_zz = 40 * 1e3 / 12 + A1 * (5 - yc) * (5 - yc) + 10 * std::pow(50, 3) / 12 +
                      A2 * (35 - yc) * (35 - yc),
               L_yy = 10 * std::pow(40, 3) / 12 + A1 * (20 - zc) * (20 - zc) + 50 * 1e3 / 12 +
                      A2 * (5 - zc) * (5 - zc),
               L_yz = A1 * (5 - yc) * (20 - zc) + A2 * (35 - yc) * (5 - zc);
  const Case cases[] = {
      {"CBAR", "PBARL,1,1,,BAR\n,0.03,0.05\n", 1.5e-3, 0.05 * 2.7e-5 / 12, 0.03 * 1.25e-4 / 12, 0, 0, 0, 4},
      {"CBAR", "PBARL,1,1,,L\n,0.04,0.06,0.01,0.01\n", 9e-4, L_yy * 1e-12, L_zz * 1e-12, L_yz * 1e-12, 0, 0,
       5},
      {"CBAR", "PBAR,1,1,1.5-3,3.125-7,1.125-7,2.-7\n,.025,.015,.025,-.015,-.025,.015,-.025,-.015\n", 1.5e-3,
       1.125e-7, 3.125e-7, 0, 0, 0, 4},
      {"CBEAM",
       "PBEAM,1,1,1.5-3,3.125-7,1.125-7,,2.-7\n,.035,.015,.035,-.015,-.015,.015,-.015,-.015\n"
       ",1.,1.\n,,,,,.01,.0\n",
       1.5e-3, 1.125e-7, 3.125e-7, 0, -0.01, 0, 4},
  };
  for (const Case& c : cases) {
    std::string deck = std::string("BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\n") + c.property;
    for (int k = 0; k <= 4; ++k) deck += fmt::format("GRID,{},,{},0.,0.\n", k + 1, 0.25 * k);
    for (int k = 0; k < 4; ++k) deck += fmt::format("{},{},1,{},{},0.,1.,0.\n", c.kind, k + 1, k + 1, k + 2);
    const Reduced r = reduce_deck(deck + "ENDDATA\n", rest);
    ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    ASSERT_TRUE(r.se.stress);
    EXPECT_EQ(r.se.stress->vertices.size(), 8 * c.points);
    VectorXd load(6);
    load << 3e4, 700, -400, 0, 150, 260;
    const VectorXd stress = r.se.stress->S * statics(r.se, 0, 1, load);
    double largest = 0;
    for (std::size_t k = 0; k < r.se.stress->vertices.size(); ++k) {
      const Eigen::Vector3d at = r.se.surface.vertices.row(r.se.stress->vertices[k]).transpose();
      // About the centroid, by the way to the tip; the axis stands (y, z) from it.
      const double N = load(0), M_y = load(4) - load(2) * (1 - at(0)) + c.z * N,
                   M_z = load(5) + load(1) * (1 - at(0)) - c.y * N;
      const double y = at(1) + c.y, z = at(2) + c.z, det = c.I_yy * c.I_zz - c.I_yz * c.I_yz;
      const double exact =
          N / c.A + ((-M_z * c.I_yy - M_y * c.I_yz) * y + (M_y * c.I_zz + M_z * c.I_yz) * z) / det;
      const VectorXd sigma = stress.segment(6 * static_cast<Eigen::Index>(k), 6);
      largest = std::max(largest, std::abs(exact));
      EXPECT_NEAR(sigma(0), exact, 1e-5 * 2e8) << c.property << " at " << at.transpose();
      EXPECT_LT(sigma.tail(5).cwiseAbs().maxCoeff(), 1e-3);
    }
    EXPECT_GT(largest, 5e7);
  }
}

// Where no points of the cross-section are given, stresses are not known, and not promised.
TEST_F(DeckBeams, StressesOfBeamsWithoutACrossSectionAreSaidToBeUnknown) {
  const std::string ends =
      "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\nnodes = [5]\n";
  const Reduced beams = reduce_deck(
      replaced(cantilever(4), "PBARL,1,1,,BAR\n,0.03,0.05", "PBAR,1,1,1.5-3,3.125-7,1.125-7,2.-7"),
      ends + "[modes]\ncount = 2\n[recovery]\nstress = true\n");
  EXPECT_EQ(beams.outcome.exit_code, 2);
  EXPECT_THAT(beams.outcome.err, HasSubstr("the stresses of 4 beams are not known"));
  const Plate plate{.lx = 1.0, .ly = 1.0, .t = 0.01, .nx = 2, .ny = 2};
  const Reduced both = reduce_deck(
      plate.nastran("PBAR,9,1,1.-3,1.-7,1.-7,1.-7\nGRID,50,,1.5,0.5,0.\nCBAR,60,9,6,50,0.,1.,0.\n"),
      "[interface.root]\n" + plate.edge([](int i, int) { return i == 0; }) +
          "[modes]\ncount = 2\n[recovery]\nstress = true\n");
  ASSERT_EQ(both.outcome.exit_code, 0) << both.outcome.err;
  EXPECT_THAT(both.outcome.err, HasSubstr("warning: the stresses of 1 beam are not known"));
  EXPECT_EQ(both.se.stress->vertices.size(), 2u * 9);
}

// Where the deck gives directions in other axes: displacement axes (CD) of Nastran's nodes, a third node of Abaqus' beams.
TEST_F(DeckBeams, DirectionsAreTakenInTheirAxes) {
  const std::string ends =
      "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\nnodes = "
      "[2]\n[modes]\ncount = 2\n";
  const auto same = [](const Reduced& a, const Reduced& b) {
    ASSERT_EQ(a.outcome.exit_code, 0) << a.outcome.err;
    ASSERT_EQ(b.outcome.exit_code, 0) << b.outcome.err;
    EXPECT_LT((a.se.K_se.topLeftCorner(12, 12) - b.se.K_se.topLeftCorner(12, 12)).norm(),
              1e-9 * a.se.K_se.topLeftCorner(12, 12).norm());
  };
  // Axis 1 of system 9 is y, axis 2 is -x; the second offset of 0.01 along y.
  const auto nastran = [](const std::string& system, const std::string& vector, const std::string& offset) {
    return "BEGIN "
           "BULK\nMAT1,1,2.1+11,,0.3,7850.\nPBARL,1,1,,BAR\n,0.03,0.05\nCORD2R,9,,0.,0.,0.,0.,0.,1.\n,0.,1.,"
           "0.\nGRID,1,,0.,0.,0.," +
           system + "\nGRID,2,,1.,0.,0.," + system + "\nGRID,3,,.5,0.,0.," + system + "\nCBAR,1,1,1,3," +
           vector + "\nCBAR,2,1,3,2," + vector + "\n,,,0.,0.,0.," + offset + "\nENDDATA\n";
  };
  same(reduce_deck(nastran("", "0.,1.,0.", "0.,.01,0."), ends),
       reduce_deck(nastran("9", "1.,0.,0.", ".01,0.,0."), ends));
  const auto abaqus = [](const std::string& third, const std::string& n1) {
    return "*NODE\n1, 0,0,0\n2, 1,0,0\n3, .5,0,0\n9, 0.,1.,0.\n*ELEMENT, TYPE=B31, ELSET=B\n1, 1,3" + third +
           "\n2, 3,2" + third + "\n*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=RECT\n.05,.03\n" + n1 +
           "*MATERIAL, NAME=S\n*ELASTIC\n2.1E11,.3\n*DENSITY\n7850.\n";
  };
  same(reduce_deck(abaqus("", "0.,1.,0.\n"), "unit = \"m\"\n" + ends, {}, "deck.inp"),
       reduce_deck(abaqus(",9", ""), "unit = \"m\"\n" + ends, {}, "deck.inp"));
  // A system of coordinates: its x is y, its origin (1, 2, 3).
  const Reduced moved = reduce_deck("*SYSTEM\n1.,2.,3., 1.,3.,3., 0.,2.,3.\n" + abaqus("", "1.,0.,0.\n"),
                                    "unit = \"m\"\n" + ends, {}, "deck.inp");
  ASSERT_EQ(moved.outcome.exit_code, 0) << moved.outcome.err;
  EXPECT_LT((moved.se.interfaces[1].p_BoN_B - Eigen::Vector3d(1, 3, 3)).norm(), 1e-12);
  for (const char* keyword : {"*NGEN", "*ELGEN", "*NFILL", "*ELCOPY"}) {
    const Reduced made =
        reduce_deck(abaqus("", "0.,1.,0.\n") + keyword + "\n1, 2\n", "unit = \"m\"\n" + ends, {}, "deck.inp");
    EXPECT_EQ(made.outcome.exit_code, 2) << keyword;
    EXPECT_THAT(made.outcome.err, HasSubstr("write the deck out with all its nodes and elements"));
  }
}

// A bar hinged in its middle (pin flag 6) is two bodies about z: it folds without strain, and bends in z as one piece,
// 4.730^2 / 2 pi l^2 sqrt(E I / rho A) (0.2 % less by shear and rotary inertia).
TEST_F(DeckBeams, ABodyThatHingesWithinItselfHasAMechanism) {
  std::string text = "BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\nPBAR,1,1,1.5-3,3.125-7,1.125-7,1.-7\n";
  for (int k = 0; k <= 8; ++k) text += fmt::format("GRID,{},,{},0.,0.\n", k + 1, k / 8.0);
  for (int k = 0; k < 8; ++k)
    text += fmt::format("CBAR,{},1,{},{},0.,1.,0.{}\n", k + 1, k + 1, k + 2, k == 4 ? ",,6" : "");
  const Reduced r = reduce_deck(text + "ENDDATA\n",
                                "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = "
                                "\"nodes\"\nnodes = [9]\n[modes]\ncount = 8\n");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  const Outcome shown = run("flexura", {"modes", output(), "--json"});
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  const superelement::ModeAnalysis modes = superelement::natural_modes(r.se, {});
  ASSERT_EQ(modes.n_rigid, 6);
  ASSERT_EQ(modes.n_mechanisms, 1);
  const superelement::Mode& fold = modes.modes[6];
  EXPECT_STREQ(superelement::kind_of(fold), "mechanism");
  EXPECT_EQ(fold.frequency_hz, 0.0);
  EXPECT_NEAR(fold.u_se.dot(r.se.M_se * fold.u_se), 1.0, 1e-9);
  // Both ends turn by opposite angles.
  EXPECT_NEAR(fold.u_se(5) / fold.u_se(11), -1.0, 1e-6);
  EXPECT_NEAR(
      modes.modes[7].frequency_hz / (22.373 / (2 * kPi) * std::sqrt(2.1e11 * 1.125e-7 / (7850 * 1.5e-3))),
      1.0, 5e-3);
  EXPECT_THAT(run("flexura", {"check", output()}).out, HasSubstr("mechanisms"));
  // Whichever way round-off leaves its stiffness.
  for (const double way : {-1.0, 1.0}) {
    superelement::Superelement se = r.se;
    const VectorXd f = se.M_se * fold.u_se;  // 1e-14 of the stiffness of the first bending mode
    se.K_se += way * 1e-14 * modes.modes[7].omega2 * f * f.transpose();
    EXPECT_EQ(superelement::natural_modes(se, {}).n_mechanisms, 1) << way;
  }
}

// A bar pinned at its end: the node's rotations there hold nothing.  3 E I / l^3 with the end's displacements retained; a
// rotation that is retained has nothing to it, and is named.
TEST_F(DeckBeams, RotationsThatNothingHoldsAreNoObstacle) {
  const std::string pinned =
      "BEGIN "
      "BULK\nMAT1,1,2.1+11,,0.3,7850.\nPBAR,1,1,1.5-3,3.125-7,1.125-7,1.-7\nGRID,1,,0.,0.,0.\nGRID,2,,.6,.8,"
      "0.\nGRID,3,,.3,.4,0.\n"
      "CBAR,1,1,1,3,0.,0.,1.\nCBAR,2,1,3,2,0.,0.,1.,,,56\nENDDATA\n";
  const std::string a = "[interface.a]\nby = \"nodes\"\nnodes = [1]\n",
                    b = "[interface.b]\nby = \"nodes\"\nnodes = [2]\n", count = "[modes]\ncount = 2\n";
  const Reduced r = reduce_deck(pinned, a + b + "directions = [\"x\", \"y\", \"z\"]\n" + count);
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  // y of the element is z: I_1 resists there.  Along (-0.8, 0.6) it is I_2.
  const int first = r.se.interfaces[1].first_dof;
  EXPECT_NEAR(r.se.K_se(first + 2, first + 2) / (3 * 2.1e11 * 3.125e-7), 1.0, 1e-9);
  const Eigen::Vector2d across(-0.8, 0.6);
  EXPECT_NEAR(across.dot(r.se.K_se.block<2, 2>(first, first) * across) / (3 * 2.1e11 * 1.125e-7), 1.0, 1e-9);
  const Reduced turned = reduce_deck(pinned, a + b + count);
  EXPECT_EQ(turned.outcome.exit_code, 2);
  EXPECT_THAT(
      turned.outcome.err,
      testing::ContainsRegex("interface 'b': its rotation about [yz] has neither stiffness nor mass"));
}

// Without interfaces the nodes of a straight bar do not say how it turns about itself; their rotations do.
TEST_F(DeckBeams, AFreeStraightBarIsReduced) {
  const Reduced r = reduce_deck(cantilever(12), "[modes]\ncount = 12\n");
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  const superelement::ModeAnalysis modes = superelement::natural_modes(r.se, {});
  EXPECT_EQ(modes.n_rigid, 6);
  // 30 mm thick, 1 m long: shear and rotary inertia take 0.4 %.
  EXPECT_NEAR(
      modes.modes[6].frequency_hz / (22.373 / (2 * kPi) * std::sqrt(2.1e11 * 1.125e-7 / (7850 * 1.5e-3))),
      1.0, 8e-3);
}

// Numbers of elements are theirs alone: what is given twice would count twice.
TEST_F(DeckBeams, ElementsGivenTwiceAreRefused) {
  const Reduced r = reduce_deck(cantilever(2, "CBAR,2,1,2,3,0.,1.,0.\n"), "[modes]\ncount = 1\n");
  EXPECT_EQ(r.outcome.exit_code, 2);
  EXPECT_THAT(r.outcome.err, AllOf(HasSubstr("CBAR 2 is given twice"), HasSubstr("line ")));
}

}  // namespace
}  // namespace flexura::test
