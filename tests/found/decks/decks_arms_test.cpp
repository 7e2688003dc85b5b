// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Rigid arms of decks: RBE2 and RBAR at the foot of one another, masses and interfaces at their ends, where no element is.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <string>

#include "mbs/superelement/modes.hpp"
#include "tests/found/parts.hpp"
#include "tests/reference.hpp"

namespace flexura::test {
namespace {

using DeckArms = Parts;

// NAFEMS FV4 (Selected Benchmarks for Natural Frequency Analysis, 1987): a cantilever of 10 m, 0.5 m thick, with 10 t and 1 t two
// metres beside its tip.  PBAR without K1, K2: no shear deformation, as in the benchmark's beams.
std::string fv4(const std::string& arms) {
  std::string deck = "SOL 103\nCEND\nBEGIN BULK\nMAT1,3,2.+11,,.3,8000.\n";
  deck += "PBAR,7,3,.19634954,.0030679616,.0030679616,.0061359232\n";
  for (int k = 0; k <= 10; ++k) deck += fmt::format("GRID,{},,{}.,0.,0.\n", k + 1, k);
  for (int k = 1; k <= 10; ++k) deck += fmt::format("CBAR,{},7,{},{},0.,0.,1.\n", k, k, k + 1);
  deck += "GRID,101,,10.,2.,0.\nGRID,102,,10.,-2.,0.\nGRID,103,,10.,1.,0.\n";
  return deck + arms + "CONM2,900,101,,10000.\nCONM2,901,102,,1000.\nENDDATA\n";
}

const std::string kRoot = "[interface.root]\nby = \"nodes\"\nnodes = [1]\n";

TEST_F(DeckArms, NafemsFV4CantileverWithOffCentreMasses) {
  const struct {
    const char *name, *cards;
  } kinds[] = {
      {"one spider", "RBE2,500,11,123456,101,102\n"},
      {"a rigid bar each", "RBAR,500,11,101,123456\nRBAR,501,11,102,123456\n"},
      {"an arm on an arm", "RBE2,501,103,123456,101\nRBE2,500,11,123456,103,102\n"},
  };
  const double published[] = {1.723, 1.727, 7.413, 9.972, 18.155, 26.957};
  for (const auto& kind : kinds) {
    const Reduced r = reduce_deck(fv4(kind.cards), kRoot + "[modes]\ncount = 12\n");
    ASSERT_EQ(r.outcome.exit_code, 0) << kind.name << ": " << r.outcome.err;
    EXPECT_NEAR(r.se.inertia.mass, 8000 * 0.19634954 * 10 + 11000, 1e-6 * 26700) << kind.name;
    const auto modes = superelement::natural_modes(r.se, {"root"}, 6).modes;
    ASSERT_EQ(modes.size(), 6u);
    for (std::size_t k = 0; k < 6; ++k)
      expect_reference(fmt::format("FV4, {}, mode {}", kind.name, k + 1), "Hz", modes[k].frequency_hz,
                       published[k], 0.002 * published[k],
                       {"NAFEMS FV4 (1987)", "its printed digits, and elements of another kind"});
  }
}

// The end of an arm, by its node or by its tie's number: the same body, seen from another place.
TEST_F(DeckArms, AnInterfaceAtTheEndOfAnArm) {
  const std::string deck = fv4("RBAR,500,11,101,123456\nRBAR,501,11,102,123456\n");
  Eigen::VectorXd load(6);
  load << 1, 2, 3, 4, 5, 6;
  Eigen::VectorXd tip;
  for (const char* end : {"by = \"nodes\"\nnodes = [11]", "by = \"tie\"\nelement = 501",
                          "by = \"nodes\"\nnodes = [101]", "by = \"nodes\"\nnodes = [102]"}) {
    const Reduced r = reduce_deck(deck, kRoot + "[interface.end]\n" + end + "\n[modes]\ncount = 6\n");
    ASSERT_EQ(r.outcome.exit_code, 0) << end << ": " << r.outcome.err;
    const superelement::Interface& at = r.se.interfaces[1];
    const Eigen::Vector3d arm = at.p_BoN_B - Eigen::Vector3d(10, 0, 0);
    // The same load at the beam's tip.
    Eigen::VectorXd there = load;
    there.tail<3>() -= arm.cross(Eigen::Vector3d(load.head<3>()));
    const Eigen::VectorXd u = statics(r.se, 0, 1, there).segment(at.first_dof, 6);
    Eigen::VectorXd at_tip = u;
    at_tip.head<3>() += arm.cross(Eigen::Vector3d(u.tail<3>()));
    if (tip.size() == 0) tip = at_tip;
    EXPECT_LT((at_tip - tip).norm(), 1e-9 * tip.norm()) << end;
  }
}

}  // namespace
}  // namespace flexura::test
