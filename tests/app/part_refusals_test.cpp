// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Bad part files: one sentence on stderr that names the place, the value, the rule and the remedy; exit code
// 2; nothing written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const char* const kPart = R"(name = "rod"
[geometry]
file = "conrod.step"
[mesh]
size = "30 mm"
elements_per_circle = 6
[material.steel]
young = "210 GPa"
poisson = 0.3
density = "7850 kg/m^3"
[interface.big_end]
by = "cylinder"
point = [0, 0, 0]
axis = [0, 0, 1]
radius = "25 mm"
[interface.small_end]
by = "cylinder"
point = ["300 mm", 0, 0]
axis = [0, 0, 1]
radius = "15 mm"
)";

class BadPart : public testing::Test {
 protected:
  BadPart() {
    std::filesystem::copy(std::filesystem::path(FLEXURA_SOURCE_DIR) / "cases/steam_engine/conrod.step",
                          folder / "conrod.step");
  }

  /// Reduces a part file that must be refused; returns the message.
  std::string refusal(const std::string& text) {
    const Outcome outcome = run(
        "flexura-reduce", {folder.write("rod.toml", text).string(), "-o", (folder / "rod.se.h5").string()});
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_THAT(outcome.err,
                AllOf(HasSubstr("error: "), Not(HasSubstr("PETSC ERROR")), Not(HasSubstr("HDF5"))));
    EXPECT_THAT(outcome.err, testing::StartsWith("error: "))
        << "nothing but the message where no terminal is";
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
      EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr("se.h5"))) << "half-written output";
    }
    return outcome.err;
  }

  Folder folder;
};

TEST_F(BadPart, MissingPartFileIsNamed) {
  const Outcome outcome = run("flexura-reduce", {(folder / "nothing.toml").string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("nothing.toml"));
}

TEST_F(BadPart, MissingCadFileIsNamedWithItsLine) {
  EXPECT_THAT(refusal(replaced(kPart, "conrod.step", "conrad.step")),
              AllOf(HasSubstr("rod.toml:3"), HasSubstr("conrad.step"), HasSubstr("no such file")));
}

TEST_F(BadPart, TextThatIsNoStepFileIsRefused) {
  folder.write("poem.step", "The woods are lovely, dark and deep\n");
  EXPECT_THAT(refusal(replaced(kPart, "conrod.step", "poem.step")),
              AllOf(HasSubstr("poem.step"), HasSubstr("STEP")));
}

TEST_F(BadPart, MisspeltKeyGetsASuggestion) {
  EXPECT_THAT(refusal(replaced(kPart, "young", "yuong")),
              AllOf(HasSubstr("rod.toml:8"), HasSubstr("yuong"), HasSubstr("did you mean \"young\"")));
}

TEST_F(BadPart, UnitOfTheWrongKindIsExplained) {
  EXPECT_THAT(refusal(replaced(kPart, "\"25 mm\"", "\"25 kg\"")),
              AllOf(HasSubstr("interface.big_end.radius"), HasSubstr("25 kg"), HasSubstr("length")));
}

TEST_F(BadPart, NegativeDensityIsRefused) {
  EXPECT_THAT(refusal(replaced(kPart, "7850", "-7850")),
              AllOf(HasSubstr("rod.toml:10"), HasSubstr("density"), HasSubstr("-7850")));
}

TEST_F(BadPart, IncompressibleMaterialIsRefused) {
  EXPECT_THAT(refusal(replaced(kPart, "poisson = 0.3", "moduli = [\"130 GPa\", \"9 GPa\", \"9 GPa\"]")),
              AllOf(HasSubstr("material.steel"), HasSubstr("moduli, ratios and shear; one of the two")));
  EXPECT_THAT(refusal(replaced(kPart, "poisson = 0.3", "poisson = 0.5")),
              AllOf(HasSubstr("poisson"), HasSubstr("0.5")));
}

TEST_F(BadPart, InterfaceThatFindsNoFaceNamesTheNearest) {
  EXPECT_THAT(refusal(replaced(kPart, "\"25 mm\"", "\"27 mm\"")),
              AllOf(HasSubstr("interface.big_end"), HasSubstr("27 mm"), HasSubstr("25 mm")));
}

TEST_F(BadPart, InterfacesThatShareNodesAreNamed) {
  const std::string text = replaced(replaced(kPart, "[\"300 mm\", 0, 0]", "[0, 0, 0]"), "radius = \"15 mm\"",
                                    "radius = \"25 mm\"");
  EXPECT_THAT(text, Not(HasSubstr("300 mm")));
  EXPECT_THAT(refusal(text), AllOf(HasSubstr("big_end"), HasSubstr("small_end"), HasSubstr("share")));
}

// A free body is sound; who forgot the interfaces reads how to add them.
TEST_F(BadPart, PartWithoutInterfaceIsAFreeBodyAndSaysSo) {
  const std::string text = kPart;
  const Outcome outcome =
      run("flexura-reduce", {folder.write("rod.toml", text.substr(0, text.find("[interface"))).string(),
                             "--modes", "2", "-o", (folder / "rod.se.h5").string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("no interface"), HasSubstr("--list-faces")));
}

}  // namespace
}  // namespace flexura::test
