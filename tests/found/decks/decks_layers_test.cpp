// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Decks whose shells have unlike layers: a strip of two metals against its beam, its mass against integrals.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tests/found/decks/plate_deck.hpp"
#include "tests/found/parts.hpp"

namespace flexura::test {
namespace {

using Eigen::MatrixXd;
using testing::HasSubstr;

class DeckLayers : public Parts {
 protected:
  static constexpr double l_ = 1.0, b_ = 0.1, t1_ = 4e-3, t2_ = 6e-3;
  const Plate plate_{
      .lx = l_, .ly = b_, .t = t1_ + t2_, .E = 70e9, .nu = 0.0, .rho = 2700.0, .nx = 8, .ny = 2};
  const std::string ends_ = "[interface.a]\n" + plate_.edge([](int i, int) { return i == 0; }) +
                            "[interface.b]\n" + plate_.edge([](int i, int) { return i == 8; }) +
                            "[modes]\ncount = 2\n";
  const std::string steel_ = "MAT1,2,2.1+11,,0.,7800.\n";

  std::string nastran(const std::string& property, const std::string& more = "") const {
    return replaced(plate_.nastran(steel_ + more), fmt::format("PSHELL,1,1,{},1,,1", plate_.t), property);
  }
  std::string abaqus(const std::string& section, const std::string& lines) const {
    std::string deck =
        replaced(plate_.abaqus(), fmt::format("MATERIAL=STEEL\n{}, 5\n", plate_.t), section + lines);
    return deck + "*MATERIAL, NAME=IRON\n*ELASTIC\n2.1E11, 0.\n*DENSITY\n7800.\n";
  }
  // The flexibility of end b with a held.
  static MatrixXd flexibility(const Reduced& r) { return r.se.K_se.block(6, 6, 6, 6).inverse(); }
  // Of a beam of two metals: aluminium from height h.
  static void expect_beam(const Reduced& r, double h) {
    ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    const double E1 = 70e9, E2 = 210e9, A = b_ * (E1 * t1_ + E2 * t2_),
                 B = b_ / 2 *
                     (E1 * (std::pow(h + t1_, 2) - h * h) +
                      E2 * (std::pow(h + t1_ + t2_, 2) - std::pow(h + t1_, 2))),
                 D = b_ / 3 *
                     (E1 * (std::pow(h + t1_, 3) - h * h * h) +
                      E2 * (std::pow(h + t1_ + t2_, 3) - std::pow(h + t1_, 3))),
                 det = A * D - B * B;
    const MatrixXd F = flexibility(r);
    EXPECT_NEAR(F(0, 0) / (l_ * D / det), 1.0, 1e-7);
    EXPECT_NEAR(F(4, 4) / (l_ * A / det), 1.0, 1e-7);
    EXPECT_NEAR(F(0, 4), -l_ * B / det, 1e-7 * l_ * std::sqrt(A * D) / det);
    // Shear is the energy of the two metals' shear stresses (shell_layers_test.cpp): 2e-4 of it here.
    EXPECT_NEAR(F(2, 2) / (l_ * l_ * l_ / 3 * A / det), 1.0, 1e-3);
    const double m1 = 2700 * l_ * b_ * t1_, m2 = 7800 * l_ * b_ * t2_, z1 = h + t1_ / 2,
                 z2 = h + t1_ + t2_ / 2;
    EXPECT_NEAR(r.se.inertia.mass, m1 + m2, 1e-9 * (m1 + m2));
    EXPECT_NEAR(r.se.inertia.S_x(2), m1 * z1 + m2 * z2, 1e-9 * (m1 + m2) * t2_);
    EXPECT_NEAR(r.se.inertia.S_xx(2, 2), m1 * (z1 * z1 + t1_ * t1_ / 12) + m2 * (z2 * z2 + t2_ * t2_ / 12),
                1e-9 * (m1 + m2) * t2_ * t2_);
  }
};

TEST_F(DeckLayers, TwoMetalsBendAndStretchAsTheirBeam) {
  const std::string layers = fmt::format(",1,{},0.,,2,{},0.", t1_, t2_);
  expect_beam(reduce_deck(nastran("PCOMP,1\n" + layers), ends_), -5e-3);
  // Z0: the bottom stands on the nodes.
  expect_beam(reduce_deck(nastran("PCOMP,1,0.\n" + layers), ends_), 0.0);
  const std::string lines = fmt::format("{}, 3, STEEL\n{}, 3, IRON\n", t1_, t2_);
  const auto inp = [&](const std::string& section) {
    return reduce_deck(abaqus(section + "\n", lines), "unit = \"m\"\n" + ends_, {}, "deck.inp");
  };
  expect_beam(inp("COMPOSITE"), -5e-3);
  expect_beam(inp("COMPOSITE, OFFSET=SNEG"), 0.0);
}

// Fibres at 30 degrees one way and the other: the section turns with THETA and MCID, and both programs mean the same.
TEST_F(DeckLayers, PliesAreTurnedWithTheirShell) {
  const std::string mat8 = "MAT8,3,1.35+11,1.+10,.3,5.+9,5.+9,4.+9,1600.\n";
  const auto deck = [&](const std::string& theta, double first, double second, const std::string& more = "") {
    std::string text =
        nastran(fmt::format("PCOMP,1\n,3,{},{:.1f},,3,{},{:.1f}", t1_, first, t2_, second), mat8 + more);
    for (std::size_t at = text.find("CQUAD4"); at != std::string::npos; at = text.find("CQUAD4", at + 1))
      text.insert(text.find('\n', at), "," + theta);
    return reduce_deck(text, ends_);
  };
  const auto K = [](const Reduced& r) {
    EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    return MatrixXd(r.se.K_se.topLeftCorner(12, 12));
  };
  const MatrixXd here = K(deck("0.", 30, -30)), turned = K(deck("20.", 10, -50)),
                 by_axes = K(deck("7", -60, -120, "CORD2R,7,0,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n"));
  // The axes in which transverse shear is shared out turn as well, which at the edges of so narrow a strip is 3e-5.
  EXPECT_LT((here - turned).norm(), 1e-4 * here.norm());
  EXPECT_LT((here - by_axes).norm(), 1e-9 * here.norm());
  EXPECT_GT((here - K(deck("0.", -30, 30))).norm(), 1e-4 * here.norm());
  const std::string inp = replaced(
      abaqus("COMPOSITE, ORIENTATION=O\n", fmt::format("{}, 3, PLY, 30.\n{}, 3, PLY, -30.\n", t1_, t2_)),
      "*SHELL SECTION", "*ORIENTATION, NAME=O\n1.,0.,0., 0.,1.,0.\n3, 0.\n*SHELL SECTION");
  EXPECT_LT((here - K(reduce_deck(
                        inp + "*MATERIAL, NAME=PLY\n*ELASTIC, TYPE=LAMINA\n1.35E11, 1.E10, .3, 5.E9, 5.E9, "
                              "4.E9\n*DENSITY\n1600.\n",
                        "unit = \"m\"\n" + ends_, {}, "deck.inp")))
                .norm(),
            1e-9 * here.norm());
}

TEST_F(DeckLayers, LayersThatCannotBeReadAreRefused) {
  const Reduced membrane =
      reduce_deck(nastran(fmt::format("PCOMP,1,,,,,,,MEM\n,1,{},0.,,2,{},0.", t1_, t2_)), ends_);
  EXPECT_EQ(membrane.outcome.exit_code, 2);
  EXPECT_THAT(membrane.outcome.err, HasSubstr("PCOMP 1 has LAM MEM, which is not read"));
  const auto inp = [&](const std::string& lines) {
    return reduce_deck(abaqus("COMPOSITE\n", lines), "unit = \"m\"\n" + ends_, {}, "deck.inp");
  };
  const Reduced bare = inp("0.004, 3\n");
  EXPECT_EQ(bare.outcome.exit_code, 2);
  EXPECT_THAT(bare.outcome.err, HasSubstr("names no material"));
  const Reduced named = inp("0.004, 3, STEEL, AXES\n");
  EXPECT_EQ(named.outcome.exit_code, 2);
  EXPECT_THAT(named.outcome.err, HasSubstr("ORIENTATION=\"AXES\" is not defined"));
  const Reduced thin = inp("0., 3, STEEL\n");
  EXPECT_EQ(thin.outcome.exit_code, 2);
  EXPECT_THAT(thin.outcome.err, HasSubstr("layer thickness"));
}

}  // namespace
}  // namespace flexura::test
