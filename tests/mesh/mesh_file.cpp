// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/mesh_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mesh/import/unv.hpp"
#include "mesh/model/geometry.hpp"
#include "tests/mesh/cad_parts.hpp"
#include "tests/mesh/scratch.hpp"

namespace flexura::mesh {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kWorker = FLEXURA_BIN_DIR "/flexura-mesh";

MeshFile read(const std::string& name) {
  return read_mesh_file(project("tests/mesh/data/gmsh/" + name), kWorker);
}

std::string refusal(const std::filesystem::path& path) {
  try {
    read_mesh_file(path, kWorker);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "(accepted)";
}

/// A bar of 1 x 1 x 3 with straight edges (data/gmsh/bar.geo) in gmsh's own formats: with the nodes in the
/// wrong order cells would be curved or turned, so a least-to-greatest det J of 1 and the volume 3 prove the
/// order.
TEST(MeshFiles, CellsOfAllFormatsAreStraightAndFillTheBar) {
  for (const auto& [name, type] :
       {std::pair{"hex20.msh", CellType::hex20}, std::pair{"hex27_binary.msh", CellType::hex27},
        std::pair{"wedge15.msh", CellType::wedge15}, std::pair{"tet10.msh", CellType::tet10}}) {
    const MeshFile file = read(name);
    const Mesh& mesh = file.mesh;
    ASSERT_EQ(mesh.solids.size(), 1u) << name;
    EXPECT_EQ(mesh.solids[0].type, type) << name;
    EXPECT_NEAR(measure_volume(mesh).volume, 3, 1e-9) << name;
    EXPECT_NEAR(measure_quality(mesh).min_ratio, 1, 1e-8) << name;
    EXPECT_NEAR(measure_surface(mesh, mesh.boundary).area, 14, 1e-9) << name;
    EXPECT_EQ(mesh.node_label.size(), static_cast<std::size_t>(mesh.n_nodes()));
    ASSERT_TRUE(mesh.sets.contains("foot")) << name;
    EXPECT_NEAR(measure_surface(mesh, mesh.sets.at("foot").faces).area, 1, 1e-9) << name;
    EXPECT_NEAR(area_weights(mesh, mesh.sets.at("top")).sum(), 1, 1e-9) << name;
    for (const Index node : mesh.sets.at("top").nodes) EXPECT_NEAR(mesh.points(node, 2), 3, 1e-9) << name;
    EXPECT_EQ(mesh.sets.at("bar").nodes.size(), static_cast<std::size_t>(mesh.n_nodes())) << name;
  }
  EXPECT_EQ(read("wedge15.msh").mesh.sets.at("group 7").nodes.size(), 1u);
}

/// The same bar as universal files (written by gmsh, read by our own reader).
TEST(UniversalFiles, CellsAreStraightAndFillTheBar) {
  for (const auto& [name, type] :
       {std::pair{"hex8.unv", CellType::hex8}, std::pair{"hex20.unv", CellType::hex20},
        std::pair{"wedge15.unv", CellType::wedge15}, std::pair{"tet10.unv", CellType::tet10}}) {
    const ImportedModel model = read_unv(project("tests/mesh/data/gmsh/") + name);
    const Mesh& mesh = model.mesh;
    ASSERT_EQ(mesh.solids.at(0).type, type) << name;
    EXPECT_NEAR(measure_volume(mesh).volume, 3, 1e-9) << name;
    EXPECT_NEAR(measure_quality(mesh).min_ratio, 1, 1e-8) << name;
    EXPECT_NEAR(measure_surface(mesh, mesh.sets.at("foot").faces).area, 1, 1e-9) << name;
    EXPECT_NEAR(area_weights(mesh, mesh.sets.at("top")).sum(), 1, 1e-9) << name;
    EXPECT_EQ(mesh.sets.at("bar").nodes.size(), static_cast<std::size_t>(mesh.n_nodes())) << name;
  }
}

TEST(UniversalFiles, RefusalsNameTheLine) {
  const auto of = [](const std::string& text) {
    const Scratch file("a.unv", text);
    try {
      read_unv(file.path());
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("(accepted)");
  };
  EXPECT_THAT(of("hello\n"), HasSubstr("a.unv, line 1: a dataset's opening -1 is wanted"));
  EXPECT_THAT(of("    -1\n  2411\n    -1\n"), HasSubstr("holds no solid elements"));
  EXPECT_THAT(of("    -1\n  2411\n 1 1 1 11\n 0.0 x 0.0\n"), HasSubstr("line 4: \"x\" is not a number"));
  EXPECT_THAT(of("    -1\n  2411\n 1 1 1 11\n"), HasSubstr("ends within a dataset; cut short?"));
  EXPECT_THAT(of("    -1\n  2412\n 1 111 1 1 7 4\n 1 2 3 4\n"), HasSubstr("line 4: node 1 does not exist"));
}

TEST(MeshFiles, RefusalsSayWhy) {
  EXPECT_THAT(refusal("nowhere.msh"), HasSubstr("nowhere.msh: no such file"));
  EXPECT_THAT(refusal(Scratch("a.msh", "").path()), HasSubstr("a.msh: is empty"));
  EXPECT_THAT(refusal(Scratch("a.msh", "once upon a time\n").path()),
              HasSubstr("not a gmsh mesh (it does not begin with $MeshFormat)"));
  EXPECT_THAT(refusal(project("tests/mesh/data/gmsh/wedge18.msh")),
              HasSubstr("which have no counterpart here"));
  EXPECT_THAT(
      refusal(
          Scratch("a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n").path()),
      HasSubstr("holds no solid cells"));
}

}  // namespace
}  // namespace flexura::mesh
