// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/beam_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <numbers>

namespace flexura::reduce {
namespace {

using ::testing::HasSubstr;

class BeamFile : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) const {
    const auto path =
        std::filesystem::temp_directory_path() / ("flexura_beam_" + std::to_string(getpid()) + ".toml");
    std::ofstream(path) << text;
    return path;
  }
  std::string refusal(const std::string& text) const {
    try {
      read_beam_part(write(text));
    } catch (const input::InputError& error) {
      return error.what();
    }
    return "no refusal";
  }
  void TearDown() override { std::filesystem::remove(write("")); }
};

const std::string kHead = R"(
[material.steel]
young = "210 GPa"
poisson = 0.3
density = "7850 kg/m^3"
[section.round]
type = "circle"
diameter = "50 mm"
[node.a]
position = [0, 0, 0]
[node.b]
position = ["1 m", 0, 0]
[interface.a]
)";

TEST_F(BeamFile, ReadsMembersSectionsMassesAndRules) {
  const BeamPartInput part = read_beam_part(write(kHead + R"(
[node.c]
position = ["1 m", 0, "0.5 m"]
[section.box]
type = "hollow_rectangle"
width = "40 mm"
height = "60 mm"
web = "3 mm"
flange = "4 mm"
shear_factor = "zero_poisson"
[section.general]
type = "advanced"
A = "10 cm^2"
I_y = "100 cm^4"
I_z = "50 cm^4"
I_t = "1 cm^4"
I_yz = "-10 cm^4"
y_cs = "-20 mm"
open_thin_walled = true
[member.first]
nodes = ["a", "b"]
section = "box"
direction = [0, 1, 0]
[member.second]
nodes = ["b", "c"]
section = "general"
theory = "euler_bernoulli"
offset_2 = [0, "10 mm", 0]
elements = 7
[mass.bell]
node = "c"
mass = "3 kg"
inertia = ["0.1 kg*m^2", "0.1 kg*m^2", "0.1 kg*m^2"]
[interface.top]
node = "c"
directions = ["x", "y", "z"]
[mesh]
elements = 3
)"));
  EXPECT_TRUE(is_beam_file(write("[member.x]\n")));
  EXPECT_FALSE(is_beam_file(write("[geometry]\n")));
  const beam::BeamMesh mesh(part.model, part.subdivision);
  EXPECT_EQ(mesh.elements().size(), 10u);
  const beam::Section& general = part.model.sections[2].section;
  EXPECT_DOUBLE_EQ(general.constants->I_yz, -1e-7);
  EXPECT_DOUBLE_EQ(general.constants->y_cs, -0.02);
  EXPECT_TRUE(std::isinf(general.constants->A_sy));
  EXPECT_DOUBLE_EQ(part.model.members[1].end[1].offset_B.y(), 0.01);
  EXPECT_EQ(part.interfaces[1].directions, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(part.interfaces[1].node, 2);
}

TEST_F(BeamFile, RefusalsNameTheTableAndTheRemedy) {
  EXPECT_THAT(
      refusal(kHead + "[member.m]\nnodes = [\"a\", \"bb\"]\n"),
      ::testing::AllOf(HasSubstr("member.m.nodes"), HasSubstr("\"bb\" is not a node, did you mean \"b\"?")));
  EXPECT_THAT(refusal(kHead + "[member.m]\nnodes = [\"a\", \"b\"]\ndirection = [2, 0, 0]\n"),
              HasSubstr("is parallel to the member's axis"));
  EXPECT_THAT(refusal(kHead + "[member.m]\nnodes = [\"a\", \"b\"]\nrelease_1 = [\"rw\"]\n"),
              HasSubstr("\"rw\" is not a direction"));
  EXPECT_THAT(refusal(kHead + "[member.m]\nnodes = [\"a\", \"a\"]\n"),
              HasSubstr("member \"m\" has no length"));
  EXPECT_THAT(refusal(kHead + "[member.m]\nnodes = [\"a\", \"b\"]\n[node.lost]\nposition = [9, 9, 9]\n"),
              HasSubstr("node \"lost\" is not connected to any member"));
  EXPECT_THAT(refusal(kHead + "[section.flat]\ntype = \"basic\"\nA = -1\nI_y = 1\nI_z = 1\nI_t = 1\n"
                              "[member.m]\nnodes = [\"a\", \"b\"]\nsection = \"flat\"\n"),
              HasSubstr("A = -1 must be positive"));
  EXPECT_THAT(
      refusal(kHead + "[section.two]\ntype = \"circle\"\ndiameter = 1\n[member.m]\nnodes = [\"a\", \"b\"]\n"),
      HasSubstr("name a section with `section`; there are 2"));
}

}  // namespace
}  // namespace flexura::reduce
