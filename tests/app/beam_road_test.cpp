// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The road of a beam: section, part, superelement, modes; and a beam that holds on to a solid.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/app/command.hpp"
#include "tests/beam/input_texts.hpp"

namespace flexura::test {
namespace {

using beam::testing::kChannelText;
using beam::testing::kSteelText;
using testing::AllOf;
using testing::HasSubstr;

TEST(SectionCommand, PrintsDrawsAndWritesWhatABeamPartReads) {
  const Folder folder;
  const auto file = folder.write("channel.toml", kSteelText + kChannelText);
  const Outcome table = run("flexura", {"section", file.string()});
  ASSERT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out,
              AllOf(HasSubstr("I_t, torsion"), HasSubstr("shear centre y"), HasSubstr("A_sz, shear area"),
                    HasSubstr("stiffness at the origin"), HasSubstr("open and thin-walled")));
  const std::string svg = read_text(folder / "channel.svg");
  EXPECT_THAT(svg, AllOf(HasSubstr("<svg"), HasSubstr("shear centre"), HasSubstr("tension centre"),
                         HasSubstr("principal axes: 1 at"), HasSubstr("</svg>")));
  const Outcome json = run("flexura", {"section", file.string(), "--json"});
  const auto figures = nlohmann::json::parse(json.out);
  // By mid-lines, h = 95, b = 47.5 mm: e = 3 b^2 / (h + 6 b); t/b = 0.1 leaves 2 %.
  EXPECT_NEAR(figures["shear_centre"][0].get<double>() / (-3 * 0.0475 * 0.0475 / (0.095 + 6 * 0.0475)), 1.0,
              0.02);

  // A cantilever of it under a load at the web sinks by F l^3 / (3 E I_y) and twists by F e l / (G I_t).
  const auto part = folder.write("boom.toml", R"([section.profile]
type = "file"
file = "channel.section"
[node.root]
position = [0, 0, 0]
[node.tip]
position = [6, 0, 0]
[member.boom]
nodes = ["root", "tip"]
warping_free = true
[interface.root]
[load.tip]
force = [0, 0, -100]
node = "tip"
[modes]
count = 6
)");
  const Outcome statics =
      run("flexura", {"reduce", part.string(), "--statics", "--report", (folder / "statics.json").string()});
  ASSERT_EQ(statics.exit_code, 0) << statics.err;
  EXPECT_THAT(statics.out, AllOf(HasSubstr("case tip"), HasSubstr("boom")));
  const auto result = nlohmann::json::parse(read_text(folder / "statics.json"))["cases"][0];
  const auto tip = result["nodes"][1]["displacement"];
  const double E = 2.1e11, G = E / 2.6, e = figures["shear_centre"][0], l = 6.0;
  const double w =
      -100 * (l * l * l / (3 * E * figures["I_y"].get<double>()) + l / (G * figures["A_sz"].get<double>()) +
              e * e * l / (G * figures["I_t"].get<double>()));
  // A_sz about the shear centre, symmetric section: the closed form is the beam's own; printed digits of
  // JSON.
  EXPECT_NEAR(tip[2].get<double>() / w, 1.0, 1e-6);
  EXPECT_NEAR(tip[3].get<double>() / (100 * e * l / (G * figures["I_t"].get<double>())), 1.0, 1e-6);
  EXPECT_FALSE(result["members"][0]["places"][0]["stresses"].empty());

  const Outcome reduced = run("flexura", {"reduce", part.string(), "-o", (folder / "boom.se.h5").string()});
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  const Outcome modes = run("flexura", {"modes", (folder / "boom.se.h5").string()});
  EXPECT_EQ(modes.exit_code, 0) << modes.err;
}

TEST(SectionCommand, HelpAndRefusals) {
  const Outcome help = run("flexura", {"section", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.out, AllOf(HasSubstr("flexura section"), HasSubstr("--svg")));
  const Outcome nothing = run("flexura", {"section"});
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_THAT(nothing.err, HasSubstr("no section file given"));
  const Folder folder;
  const auto file = folder.write("s.toml", kSteelText);
  const Outcome onto_itself = run("flexura", {"section", file.string(), "-o", file.string()});
  EXPECT_EQ(onto_itself.exit_code, 2);
  EXPECT_THAT(onto_itself.err, HasSubstr("would be overwritten by what is made of it"));
  const Outcome empty = run("flexura", {"section", file.string()});
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_THAT(empty.err, AllOf(HasSubstr("error: "), HasSubstr("the section has no material")));
  EXPECT_FALSE(std::filesystem::exists(folder / "s.section"));
}

TEST(BeamRoad, AShaftHalfSolidHalfBeamVibratesLikeTheWhole) {
  // The shaft of cases/simbeam_shaft, d = 0.25 m: a solid metre and a metre of beam behind it.
  const Folder folder;
  std::filesystem::copy(std::filesystem::path(FLEXURA_SOURCE_DIR) / "cases/simbeam_shaft/shaft_1m.step",
                        folder / "shaft_1m.step");
  folder.write("solid.toml", std::string(R"([geometry]
file = "shaft_1m.step"
[mesh]
size = "100 mm"
[interface.left]
by = "plane"
point = [0, 0, 0]
normal = [1, 0, 0]
tie = "average"
[interface.right]
by = "plane"
point = [1, 0, 0]
normal = [1, 0, 0]
[modes]
count = 20
)") + kSteelText);
  const auto part = folder.write("shaft.toml", kSteelText + R"(
[section.round]
type = "circle"
diameter = "0.25 m"
[solid.front]
part = "solid.toml"
[node.end]
position = [2, 0, 0]
[member.rear]
nodes = ["front.right", "end"]
elements = 20
[interface.left]
node = "front.left"
[interface.end]
[modes]
count = 60
)");
  const Outcome reduced = run("flexura", {"reduce", part.string(), "-o", (folder / "shaft.se.h5").string()});
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  EXPECT_THAT(reduced.out, HasSubstr("solid front"));
  const Outcome modes =
      run("flexura", {"modes", (folder / "shaft.se.h5").string(), "--free", "-n", "10", "--json"});
  ASSERT_EQ(modes.exit_code, 0) << modes.err;
  std::vector<double> hz;
  const auto json = nlohmann::json::parse(modes.out);
  for (const auto& mode : json["analyses"][0]["modes"])
    if (mode["frequency_hz"].get<double>() > 1.0) hz.push_back(mode["frequency_hz"]);
  ASSERT_GE(hz.size(), 4u);
  // A free shaft of 2 m (three-dimensional Ritz solution): 276.83 and 716.83 Hz.  The rigid plate at the tie
  // and the coarse mesh stay below 1 %.
  EXPECT_NEAR(hz[0] / 276.83, 1.0, 0.01);
  EXPECT_NEAR(hz[1] / 276.83, 1.0, 0.01);
  EXPECT_NEAR(hz[2] / 716.83, 1.0, 0.015);

  const Outcome lost = run("flexura", {"reduce", part.string(), "--set", "solid.front.part=\"none.toml\""});
  EXPECT_EQ(lost.exit_code, 2);
  EXPECT_THAT(lost.err, AllOf(HasSubstr("solid.front.part"), HasSubstr("there is no such file")));
}

}  // namespace
}  // namespace flexura::test
