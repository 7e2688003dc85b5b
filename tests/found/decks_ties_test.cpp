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
  const Reduced apart = reduced(deck(0.04, "*TIE, NAME=T\nRIGHT, LEFT\n", 9));
  EXPECT_NE(apart.outcome.exit_code, 0);
  const Reduced bound = reduced(deck(0.0, "*EQUATION\n2\n7, 1, 1., 8, 1, -1.\n*MPC\nSLIDER, 6, 7, 8\n", 5));
  ASSERT_EQ(bound.outcome.exit_code, 0) << bound.outcome.err;
  EXPECT_THAT(bound.outcome.err,
              AllOf(HasSubstr("warning: 1 keyword *EQUATION is not used"), HasSubstr("*MPC of type SLIDER"),
                    HasSubstr("what it binds stays apart")));
  EXPECT_THAT(bound.outcome.out, HasSubstr("with care: "));
}

}  // namespace
}  // namespace flexura::test
