// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mesh/import/abaqus.hpp"
#include "mesh/model/geometry.hpp"
#include "tests/mesh/scratch.hpp"

namespace flexura::mesh {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string data(const std::string& name) {
  return FLEXURA_SOURCE_DIR "/tests/mesh/data/" + name;
}

ImportedModel read_text(const std::string& text) {
  return read_abaqus(Scratch("deck.inp", text).path());
}

std::string refusal(const std::string& text) {
  try {
    read_text(text);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "(accepted)";
}

/// The block is 4 x 1 x 1 m: volume 4, centre (2, 1/2, 1/2), surface 18; coordinates carry ten digits, so
/// sums over a hundred cells agree to 1e-9.
TEST(AbaqusDeck, BlockHasItsVolumeAndSurface) {
  for (const auto& [name, type, n_nodes, n_cells] :
       {std::tuple{"blockC3D4.inp", CellType::tet4, 214, 767},
        std::tuple{"blockC3D10.inp", CellType::tet10, 257, 122}}) {
    const ImportedModel model = read_abaqus(data(name));
    const Mesh& mesh = model.mesh;
    ASSERT_EQ(mesh.solids.size(), 1u) << name;
    EXPECT_EQ(mesh.solids[0].type, type);
    EXPECT_EQ(mesh.n_nodes(), n_nodes) << name;
    EXPECT_EQ(mesh.n_solid_cells(), n_cells) << name;
    EXPECT_EQ(mesh.node_label[0], 1);
    const Volumes v = measure_volume(mesh);
    EXPECT_NEAR(v.volume, 4, 1e-9) << name;
    EXPECT_LT((v.centroid - Eigen::Vector3d(2, 0.5, 0.5)).norm(), 1e-9) << name;
    EXPECT_NEAR(measure_surface(mesh, mesh.boundary).area, 18, 1e-9) << name;
    ASSERT_EQ(model.materials.size(), 1u);
    EXPECT_EQ(model.materials[0].name, "steel");
    EXPECT_EQ(model.materials[0].E, 2e11);
    EXPECT_EQ(model.materials[0].nu, 0.3);
    EXPECT_EQ(model.materials[0].rho, 2900);
    EXPECT_EQ(mesh.sets.at("Set-1").nodes.size(), static_cast<std::size_t>(n_nodes));
    EXPECT_THAT(model.messages, ::testing::IsEmpty());
  }
}

/// Twenty-node elements over two lines each, parts that are placed by the assembly: closed, unturned, one
/// piece; the divergence theorem (surface and volume rules are independent) ties cells and faces together to
/// round-off.
TEST(AbaqusDeck, ConrodAndCrankAreClosedBodies) {
  for (const char* name : {"job_matrix_generate_conrod.inp", "job_matrix_generate_crank.inp"}) {
    const ImportedModel model = read_abaqus(data(name));
    EXPECT_EQ(model.mesh.solids.at(0).type, CellType::hex20);
    EXPECT_EQ(measure_quality(model.mesh).n_inverted, 0) << name;
    EXPECT_EQ(find_pieces(model.mesh).count, 1) << name;
    const Surface s = measure_surface(model.mesh, model.mesh.boundary);
    EXPECT_LT(s.normal.norm(), 1e-12) << name;
    EXPECT_GT(model.materials.at(0).E, 1e11) << name;
  }
}

constexpr const char* kNodes = "*NODE\n1, 0,0,0\n2, 1,0,0\n3, 0,1,0\n4, 0,0,1\n5, 1,1,1\n";

TEST(AbaqusDeck, InstancesAreTurnedAndMoved) {
  const ImportedModel model =
      read_text(std::string("*PART, NAME=a\n") + kNodes +
                "*ELEMENT, TYPE=C3D4, ELSET=E\n1,1,2,3,4\n*NSET, NSET=tip\n4\n*END PART\n"
                "*ASSEMBLY, NAME=x\n*INSTANCE, NAME=i1, PART=a\n*END INSTANCE\n"
                "*INSTANCE, NAME=i2, PART=A\n10,0,0\n10,0,0, 10,1,0, 90\n*END INSTANCE\n"
                "*NSET, NSET=corner, INSTANCE=i2\n 1\n*END ASSEMBLY\n");
  ASSERT_EQ(model.mesh.n_solid_cells(), 2);
  const Index tip = model.mesh.sets.at("i2.tip").nodes.at(0),
              corner = model.mesh.sets.at("corner").nodes.at(0);
  // The tip (0,0,1) goes to (10,0,1), then 90 degrees about the y axis through (10,0,0): (11,0,0).
  EXPECT_LT((model.mesh.points.row(tip) - Eigen::RowVector3d(11, 0, 0)).norm(), 1e-14);
  EXPECT_LT((model.mesh.points.row(corner) - Eigen::RowVector3d(10, 0, 0)).norm(), 1e-14);
}

TEST(AbaqusDeck, UnusedKeywordsAreCounted) {
  const ImportedModel model = read_text(std::string(kNodes) +
                                        "*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n*ELEMENT, "
                                        "TYPE=S3\n7,1,2,3\n8,1,3,4\n*ELEMENT, TYPE=CPS3\n9,1,2,3\n10,1,3,4\n"
                                        "*SURFACE, NAME=S\nE, S1\n");
  EXPECT_THAT(
      model.messages,
      ::testing::Contains(HasSubstr("2 shell elements (S3, S4, ...) have no section and are not used")));
  EXPECT_THAT(model.warnings, ::testing::ElementsAre(HasSubstr("2 elements CPS3 are not used (first in")));
  EXPECT_THAT(model.warnings, ::testing::Contains(HasSubstr("deck.inp, line 13)")));
  EXPECT_THAT(model.messages, ::testing::Contains(HasSubstr("1 keyword *SURFACE is not used")));
}

TEST(AbaqusDeck, NumbersThatNoStructureHasAreRefusedWithTheirLine) {
  const std::string steel = "*MATERIAL, NAME=S\n*ELASTIC\n2.1E11,.3\n", nodes = kNodes;
  const auto section = [&](const std::string& element, const std::string& words) {
    return refusal(nodes + "*ELEMENT, ELSET=E, TYPE=" + element + "\n" + words + "\n" + steel);
  };
  for (const char* const t : {"-1E-3", "0"})
    EXPECT_THAT(section("S3\n1,1,2,3", std::string("*SHELL SECTION, ELSET=E, MATERIAL=S\n") + t),
                AllOf(HasSubstr("line 9: *SHELL SECTION has the thickness"), HasSubstr("above 0")));
  EXPECT_THAT(section("T3D2\n1,1,2", "*SOLID SECTION, ELSET=E, MATERIAL=S\n-1E-4"),
              HasSubstr("line 9: truss element 1 has the area -0.0001; it must be above 0"));
  EXPECT_THAT(section("T3D2\n1,1,2", "*BEAM SECTION, ELSET=E, MATERIAL=S, SECTION=RECT\n.1,.1\n0,0,1"),
              HasSubstr("line 9: truss element 1 has a section of beams"));
  const std::string general = "*BEAM GENERAL SECTION, ELSET=E, SECTION=GENERAL\n";
  EXPECT_THAT(section("B31\n1,1,2", general + "1E-4,-1E-8,0,1E-8,1E-8\n0,0,1\n2.1E11,8E10"),
              HasSubstr("line 9: beam element 1 has the second moment of area I_yy -1e-08"));
  EXPECT_THAT(section("B31\n1,1,2", general + "1E-4,1E-8,3E-8,1E-8,1E-8\n0,0,1\n2.1E11,8E10"),
              HasSubstr("product of area I_yz = 3e-08"));
  EXPECT_THAT(refusal(nodes + "*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n*ELEMENT, TYPE=SPRINGA, "
                              "ELSET=E\n2,1,2\n*SPRING, ELSET=E\n\n-5.\n"),
              HasSubstr("has the stiffness -5; it must be at least 0"));
}

TEST(AbaqusDeck, RefusalsNameFileLineAndRemedy) {
  const std::string nodes = kNodes;
  EXPECT_THAT(refusal(nodes + "*ELEMENT, TYPE=C3D4\n1,1,2,3,9\n"),
              HasSubstr("line 8: element 1 names node 9, which does not exist"));
  EXPECT_THAT(refusal(nodes + "*ELEMENT, TYPE=C3D4\n1,1,2,3\n"),
              HasSubstr("element 1 of type C3D4 has 3 nodes instead of 4"));
  EXPECT_THAT(refusal(nodes + "*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n1,2,3,4,5\n"),
              HasSubstr("line 9: element 1 is given twice"));
  EXPECT_THAT(refusal(nodes + "1, 0,0,0\n"), HasSubstr("line 7: node 1 is given twice"));
  EXPECT_THAT(refusal(nodes + "*ELEMENT, TYPE=C3D4, ELSET=E\n1,1,2,3,4\n*SOLID SECTION, ELSET=E, "
                              "MATERIAL=stel\n*MATERIAL, NAME=steel\n"),
              HasSubstr("material \"stel\" is not defined"));
  EXPECT_THAT(refusal(nodes + "*NODE\n6, 1,x,0\n"), HasSubstr("line 8: \"x\" is not a number"));
  EXPECT_THAT(refusal(nodes), HasSubstr("holds no solid, shell or beam elements"));
  EXPECT_THROW(read_abaqus("no_such.inp"), std::invalid_argument);
}

}  // namespace
}  // namespace flexura::mesh
