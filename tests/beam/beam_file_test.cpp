// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/beam_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "beam/model/section_stress.hpp"
#include "reduce/linalg/session/session.hpp"
#include "tests/beam/input_texts.hpp"

namespace flexura::reduce {
namespace {

using beam::testing::kRoundText;
using beam::testing::kSteelText;
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

const std::string kHead = kSteelText + kRoundText + R"(
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
      refusal(kHead + "[section.m6]\ntype = \"matrix\"\n"
                      "stiffness = [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,2],"
                      "[0,0,0,0,2,1]]\n"
                      "mass = [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,2,0,0],[0,0,0,0,1,0],"
                      "[0,0,0,0,0,1]]\n"
                      "[member.m]\nnodes = [\"a\", \"b\"]\nsection = \"m6\"\n"),
      ::testing::AllOf(HasSubstr("section.m6"), HasSubstr("not positive definite")));
  EXPECT_THAT(
      refusal(kHead + "[section.two]\ntype = \"circle\"\ndiameter = 1\n[member.m]\nnodes = [\"a\", \"b\"]\n"),
      HasSubstr("name a section with `section`; there are 2"));
}

TEST_F(BeamFile, CurvesOfCadFilesAndGmshModelsBecomeMembers) {
  // A portal with an arch over it: three straight curves and half a circle of radius 2 m.
  const std::string data = FLEXURA_SOURCE_DIR "/tests/beam/data/";
  const std::string head = kSteelText + kRoundText + R"(
[node.foot]
position = [0, 0, 0]
[interface.foot]
)";
  const BeamPartInput cad =
      read_beam_part(write(head + "[curves.portal]\nfile = \"" + data + "portal.step\"\n"));
  // 180 degrees by 5: 36 pieces.  Their ends lie on the arch, at its ends on the portal's corners.
  ASSERT_EQ(cad.model.members.size(), 3u + 36u);
  EXPECT_EQ(cad.model.nodes.size(), 4u + 35u);
  double length = 0.0;
  int at_foot = 0;
  for (const beam::Member& member : cad.model.members) {
    const Eigen::Vector3d p = cad.model.nodes[member.end[0].node].p_BoN_B,
                          q = cad.model.nodes[member.end[1].node].p_BoN_B;
    length += (p - q).norm();
    at_foot += member.end[0].node == 0 || member.end[1].node == 0;
    if (std::max(p.z(), q.z()) > 3.0 + 1e-9) {
      EXPECT_NEAR((p - Eigen::Vector3d(2, 0, 3)).norm(), 2.0, 1e-9);
    }
  }
  EXPECT_EQ(at_foot, 1);
  const double arc = 2.0 * std::numbers::pi, chord = std::numbers::pi / 36;
  EXPECT_NEAR(length, 3 + 4 + 3 + arc * std::sin(chord / 2) / (chord / 2), 1e-6);
  // The same with groups, from gmsh's mesh: 500 mm line elements; its numbers are mm.
  const BeamPartInput mesh = read_beam_part(write(
      head + "[section.thin]\ntype = \"circle\"\ndiameter = \"20 mm\"\n[curves.legs]\nfile = \"" + data +
      "portal.msh\"\nunit = \"mm\"\ngroup = \"legs\"\nsection = \"round\"\nelements = 1\n[curves.roof]\nfile "
      "= \"" +
      data + "portal.msh\"\nunit = \"mm\"\ngroup = \"roof\"\nsection = \"thin\"\n[mesh]\nelements = 2\n"));
  int thick = 0;
  for (const beam::Member& member : mesh.model.members) thick += member.section == 0;
  EXPECT_EQ(thick, 12);
  const beam::BeamMesh beams(mesh.model, mesh.subdivision);
  EXPECT_EQ(beams.elements().size(), 12u + 2u * (mesh.model.members.size() - 12u));

  EXPECT_THAT(refusal(head + "[curves.portal]\nfile = \"" + data + "portal.msh\"\ngroup = \"leg\"\n"),
              HasSubstr("no physical group of curves \"leg\", did you mean \"legs\"?"));
  EXPECT_THAT(refusal(head + "[curves.portal]\nfile = \"" + data + "portal.step\"\ncurves = [9]\n"),
              HasSubstr("the file has no curve 9; it has 4 curves, 1 to 4"));
  EXPECT_THAT(refusal(head + "[curves.portal]\nfile = \"" + data + "ring_section.step\"\n"),
              HasSubstr("holds faces or solids, whose edges are no beams"));
}

TEST_F(BeamFile, LoadsOfACaseAddUpAndSectionForcesBalanceThem) {
  const BeamPartInput part = read_beam_part(write(kHead + R"(
[member.m]
nodes = ["a", "b"]
elements = 3
[load.tip]
case = "crane"
node = "b"
force = [0, 0, "-2 kN"]
[load.own]
case = "crane"
member = "m"
line_force = [0, 0, "-100 N/m"]
line_force_2 = [0, 0, "-300 N/m"]
[load.twist]
node = "b"
moment = ["5 N*m", 0, 0]
)"));
  ASSERT_EQ(part.cases.size(), 2u);
  EXPECT_EQ(part.cases[0].name, "crane");
  const linalg::Session session;
  const Structure structure(beam::BeamMesh(part.model, part.subdivision));
  const Eigen::MatrixXd U = static_displacements(structure, part.interfaces, part.cases);
  // Cantilever held at x = 0: V_z(x) = 2000 + int_x^1 (100 + 200 s) ds, M_y(0) = -(2000 + int s (100 + 200 s)
  // ds), positive M_y stretching the side of +z: a load down stretches the top.
  for (const auto& r : beam::member_results(structure.mesh(), 0, U.col(0), 5, part.cases[0].members)) {
    const double x = r.x, rest = 100 * (1 - x) + 100 * (1 - x * x);
    EXPECT_NEAR(r.resultants(beam::V_z), -(2000 + rest), 1e-6);
    const double moment = 2000 * (1 - x) + 50 * (1 - x * x) + 200.0 / 3 * (1 - x * x * x) - x * rest;
    EXPECT_NEAR(std::abs(r.resultants(beam::M_y)), moment, 1e-6);
  }
  // Stress at the root of a round bar: M r / I at top or bottom.
  const auto root = beam::member_results(structure.mesh(), 0, U.col(0), 2, part.cases[0].members).front();
  double greatest = 0.0;
  for (const auto& s : beam::section_stresses(structure.mesh(), 0, 0.0, root.resultants))
    greatest = std::max(greatest, s.sigma_xx);
  EXPECT_NEAR(greatest / ((2000 + 50 + 200.0 / 3) * 0.025 / (std::numbers::pi * std::pow(0.05, 4) / 64)), 1.0,
              1e-9);
  // Torsion: tau = T r / I_p.
  const auto twisted = beam::member_results(structure.mesh(), 0, U.col(1), 2).front();
  double tau = 0.0;
  for (const auto& s : beam::section_stresses(structure.mesh(), 0, 0.0, twisted.resultants))
    tau = std::max(tau, std::hypot(s.tau_xy, s.tau_xz));
  EXPECT_NEAR(tau / (5 * 0.025 / (std::numbers::pi * std::pow(0.05, 4) / 32)), 1.0, 1e-9);

  EXPECT_THAT(refusal(kHead + "[member.m]\nnodes = [\"a\", \"b\"]\n[load.p]\nforce = [1, 0, 0]\n"),
              HasSubstr("load.p: give either `node` or `member`"));
  EXPECT_THAT(
      refusal(kHead + "[member.m]\nnodes = [\"a\", \"b\"]\n[load.p]\nmember = \"m\"\nforce = [1, 0, 0]\n"),
      HasSubstr("along a member write line_force"));
}

}  // namespace
}  // namespace flexura::reduce
