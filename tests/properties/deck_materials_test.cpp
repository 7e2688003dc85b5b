// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A material of an Abaqus deck has its constants wherever they stand among its other options, and what a deck says twice is told.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "mesh/import/abaqus.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::mesh {
namespace {

using mbs::chance::Chance;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

class DeckMaterials : public mbs::test::TestFolder {
 protected:
  ImportedModel read(const std::string& more) const {
    return read_abaqus(
        file("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n*ELEMENT, TYPE=B31, ELSET=E\n1, 1, 2\n" + more, "deck.inp"),
        DeckProgram::abaqus);
  }
};
constexpr const char* kSection = "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=RECT\n0.05, 0.03\n0, 1, 0\n";

TEST_F(DeckMaterials, EndAtTheNextCardThatIsNoOptionOfOne) {
  const std::vector<std::string> others = {"*EXPANSION\n1e-5\n",
                                           "*PLASTIC, HARDENING=COMBINED\n1e8, 0\n2e8, 0.1\n",
                                           "*CONDUCTIVITY\n50\n",
                                           "*SPECIFIC HEAT\n460\n",
                                           "*DEPVAR\n3\n",
                                           "*CREEP\n1, 1, 1\n",
                                           "*NO COMPRESSION\n",
                                           "*ACOUSTIC MEDIUM\n1\n",
                                           "*VISCOELASTIC, TIME=PRONY\n0.1, 0.1, 1\n",
                                           "*USER MATERIAL, CONSTANTS=1\n1\n",
                                           "*DAMAGE INITIATION, CRITERION=DUCTILE\n1, 0, 0\n",
                                           "*DAMAGE EVOLUTION, TYPE=DISPLACEMENT\n0.1\n",
                                           "** a comment\n"};
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const double E = chance.between(1e9, 3e11), nu = chance.between(0.0, 0.45),
                 rho = chance.between(500.0, 9000.0);
    std::vector<std::string> cards = {fmt::format("*ELASTIC\n{:.17g}, {:.17g}\n", E, nu),
                                      fmt::format("*DENSITY\n{:.17g}\n", rho)};
    for (int n = chance.below(6); n > 0; --n)
      cards.push_back(others[static_cast<std::size_t>(chance.below(13))]);
    for (std::size_t k = cards.size(); k > 1; --k)
      std::swap(cards[k - 1], cards[static_cast<std::size_t>(chance.below(static_cast<int>(k)))]);
    const std::string material = "*MATERIAL, NAME=M\n" + fmt::format("{}", fmt::join(cards, ""));
    // Cards after its end are none of it.
    const std::string stray = "*BOUNDARY\n1, 1, 6\n*DENSITY\n1\n";
    const ImportedModel model =
        read(chance.flip(0.5) ? kSection + material + stray : material + kSection + stray);
    ASSERT_EQ(model.materials.size(), 1u);
    EXPECT_DOUBLE_EQ(model.materials[0].E, E);
    EXPECT_DOUBLE_EQ(model.materials[0].nu, nu);
    EXPECT_DOUBLE_EQ(model.materials[0].rho, rho);
    EXPECT_TRUE(model.warnings.empty()) << fmt::format("{}", fmt::join(model.warnings, "\n"));
    EXPECT_THAT(model.messages, Contains(HasSubstr("*DENSITY")));
  }
}

TEST_F(DeckMaterials, ThatContradictThemselvesAreTold) {
  const std::string elastic = "*ELASTIC\n2.1E11, 0.3\n", density = "*DENSITY\n7850\n",
                    name = "*MATERIAL, NAME=M\n";
  struct Case {
    std::string deck;
    std::vector<std::string> told;
    double E = 2.1e11, rho = 7850, A = 0.0015;
  };
  const std::vector<Case> cases = {
      {kSection + name + elastic + density, {}},
      {kSection + name + "*ELASTIC\n2.1E11, 0.3, 20\n" + density, {}},
      {kSection + name + "*ELASTIC, DEPENDENCIES=1\n2.1E11, 0.3, 20, 1\n" + density, {}},
      {kSection + name + "*ELASTIC\n2.1E11, 0.3, 20\n1E11, 0.3, 200\n" + density,
       {"*ELASTIC has 2 rows", "line 10"}},
      {kSection + name +
           "*ELASTIC, DEPENDENCIES=7\n2.1E11, 0.3, 20, 1, 2, 3, 4, 5\n6, 7\n1E11, 0.3, 20, 1, 2, 3, 4, "
           "5\n6, 7\n" +
           density,
       {"*ELASTIC has 2 rows"}},
      {kSection + name + "*ELASTIC\n2.1E11, 0.3, 20, 7, 8\n" + density, {"*ELASTIC has 5 numbers"}},
      {kSection + name + elastic + "*DENSITY\n7850, 20\n2000, 100\n", {"*DENSITY has 2 rows"}},
      {kSection + name + elastic + density + "*ELASTIC\n1E11, 0.3\n",
       {"*ELASTIC is given twice", "line 14"},
       1e11},
      {kSection + name + elastic + density + "*DENSITY\n1000\n", {"*DENSITY is given twice"}, 2.1e11, 1000},
      {kSection + name + elastic + density + "*MATERIAL, NAME=m\n*ELASTIC\n1E11, 0.3\n*DENSITY\n1\n",
       {"NAME=M is given twice: the one of", "line 9 is taken"}},
      {kSection + name + elastic + density +
           "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=RECT\n0.5, 0.3\n0, 1, 0\n",
       {"have one of", "line 6 already"},
       2.1e11,
       7850,
       0.15},
      {name + elastic + density +
           "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=RECT\n0.05, 0.03, 0.01\n0, 1, 0\n",
       {"SECTION=RECT has 3 numbers"}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.deck);
    const ImportedModel model = read(c.deck);
    ASSERT_EQ(model.warnings.size(), c.told.empty() ? 0u : 1u)
        << fmt::format("{}", fmt::join(model.warnings, "\n"));
    for (const std::string& words : c.told) EXPECT_THAT(model.warnings[0], HasSubstr(words));
    EXPECT_EQ(model.materials[0].E, c.E);
    EXPECT_EQ(model.materials[0].rho, c.rho);
    EXPECT_NEAR(model.bars[0].A, c.A, 1e-12 * c.A);  // a product of two numbers of the deck
  }
}

}  // namespace
}  // namespace flexura::mesh
