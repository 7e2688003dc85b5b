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

}  // namespace
}  // namespace flexura::test
