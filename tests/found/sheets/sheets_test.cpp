// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Sheet metal: shells on the faces of a CAD file ([shell]).  Drawn for this: sheets/square.brep, 10 x 10; sheets/bracket.brep, a
// base of 120 x 60 with a hole of radius 10 at (30, 30), a flange of 60 x 40 at x = 120, and a rib of 60 x 20 between both that
// shares no edge with them.
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
using testing::HasSubstr;
constexpr double kPi = std::numbers::pi;

class Sheets : public Parts {
 protected:
  Outcome reduce(const std::string& geometry, const std::string& rest, const std::string& thickness,
                 std::vector<std::string> options = {}) {
    const auto part = folder_.write(
        "part.toml", fmt::format("[geometry]\n{}\n[shell]\nthickness = {}\n[material.steel]\nyoung = "
                                 "\"200 GPa\"\npoisson = 0.3\ndensity = 8000\n{}",
                                 geometry, thickness, rest));
    return Parts::reduce(part, std::move(options)).outcome;
  }
  static std::string file(const std::string& name) {
    return "file = \"" FLEXURA_SOURCE_DIR "/tests/found/" + name + "\"";
  }
  superelement::Superelement se() const {
    return superelement::read(output(), {.surface = true, .stress = true});
  }
};

// NAFEMS FV16, a cantilevered square plate (Selected benchmarks for natural frequency analysis, 1987): 10 x 10 x 0.05 m.
TEST_F(Sheets, NafemsFV16FromACadFace) {
  const Outcome outcome =
      reduce(file("sheets/square.brep") + "\nunit = \"m\"",
             "[interface.root]\nby = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\n[modes]\ncount = 6\n",
             "\"50 mm\"");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const VectorXd hz = se().omega2.cwiseSqrt() / (2 * kPi);
  const double published[] = {0.421, 1.029, 2.582, 3.306, 3.753, 6.555};
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(hz(k) / published[k], 1.0, 0.012) << k;
  EXPECT_NEAR(se().inertia.mass, 8000 * 0.05 * 100, 1e-6);
  EXPECT_THAT(outcome.out, testing::AllOf(HasSubstr("a sheet of 1 face, 50 mm thick"), HasSubstr("unknown")));
}

// Faces that meet hang together, also where one ends on another; interfaces by the edge of a hole, by a rim, by a face.
TEST_F(Sheets, ABracketIsOneBody) {
  const Outcome outcome = reduce(
      file("sheets/bracket.brep"),
      "[interface.hole]\nby = \"cylinder\"\npoint = [\"30 mm\", \"30 mm\", 0]\naxis = [0, 0, 1]\nradius "
      "= \"10 mm\"\n[interface.rim]\nby = \"plane\"\npoint = [0, 0, \"40 mm\"]\nnormal = [0, 0, 1]\n"
      "[modes]\ncount = 4\n[recovery]\nstress = true\n[mesh]\nsize = \"8 mm\"\n",
      "\"2 mm\"");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const superelement::Superelement bracket = se();
  // The hole is a polygon of at least eight sides: its area within 10 %.
  const double plates = 0.12 * 0.06 + 0.06 * 0.04 + 0.06 * 0.02, hole = kPi * 1e-4;
  EXPECT_NEAR(bracket.inertia.mass, 8000 * 0.002 * (plates - hole), 8000 * 0.002 * 0.1 * hole);
  EXPECT_LT((bracket.interfaces[0].p_BoN_B - Eigen::Vector3d(0.03, 0.03, 0)).norm(), 1e-6);
  EXPECT_LT((bracket.interfaces[1].p_BoN_B - Eigen::Vector3d(0.12, 0.03, 0.04)).norm(), 1e-6);
  ASSERT_TRUE(bracket.stress);
  const Outcome faces = run("flexura-reduce", {"--list-faces", (folder_ / "part.toml").string()});
  EXPECT_EQ(faces.exit_code, 0) << faces.err;
  EXPECT_THAT(faces.out, HasSubstr("faces\n"));
}

// The mesh written as a deck, with its thickness and material, is the same sheet.
TEST_F(Sheets, WrittenAsADeckIsTheSame) {
  const std::string rest =
      "[interface.rim]\nby = \"plane\"\npoint = [0, 0, \"40 mm\"]\nnormal = [0, 0, 1]\n[modes]\ncount = 3\n";
  const Outcome outcome = reduce(file("sheets/bracket.brep"), rest + "[mesh]\nsize = \"15 mm\"\n", "\"2 mm\"",
                                 {"--mesh", (folder_ / "again.inp").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const superelement::Superelement first = se();
  const auto part = folder_.write("again.toml", "[geometry]\nfile = \"again.inp\"\nunit = \"m\"\n" + rest);
  const Outcome again = run("flexura-reduce", {part.string(), "-o", output()});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NEAR(se().inertia.mass / first.inertia.mass, 1.0, 1e-12);
  EXPECT_LT((se().omega2 - first.omega2).norm(), 1e-8 * first.omega2.norm());
}

// The same plate as a mesh of gmsh's own, of quadrilaterals and of triangles, its root a physical group.
TEST_F(Sheets, NafemsFV16FromAMesh) {
  constexpr int n = 12;
  const double published[] = {0.421, 1.029, 2.582, 3.306, 3.753, 6.555};
  const std::string rest = "[interface.root]\nby = \"group\"\ngroup = \"root\"\n[modes]\ncount = 6\n";
  const auto node = [](int i, int j) { return 1 + i + (n + 1) * j; };
  for (const bool triangles : {false, true}) {
    std::string nodes, cells;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i)
        nodes += fmt::format("{} {} {} 0\n", node(i, j), 10.0 * i / n, 10.0 * j / n);
    int count = 0;
    for (int j = 0; j < n; ++j)
      cells += fmt::format("{} 1 2 7 1 {} {}\n", ++count, node(0, j), node(0, j + 1));
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = node(i, j), b = node(i + 1, j), c = node(i + 1, j + 1), d = node(i, j + 1);
        if (triangles) {
          cells += fmt::format("{} 2 2 8 1 {} {} {}\n", ++count, a, b, c);
          cells += fmt::format("{} 2 2 8 1 {} {} {}\n", ++count, a, c, d);
        } else {
          cells += fmt::format("{} 3 2 8 1 {} {} {} {}\n", ++count, a, b, c, d);
        }
      }
    folder_.write(
        "plate.msh",
        fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"root\"\n2 8 \"sheet\"\n"
                    "$EndPhysicalNames\n$Nodes\n{}\n{}$EndNodes\n$Elements\n{}\n{}$EndElements\n",
                    (n + 1) * (n + 1), nodes, count, cells));
    std::filesystem::remove(output());
    const Outcome outcome = reduce("file = \"plate.msh\"\nunit = \"m\"", rest, "\"50 mm\"");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const VectorXd hz = se().omega2.cwiseSqrt() / (2 * kPi);
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(hz(k) / published[k], 1.0, 0.02) << k;
    EXPECT_NEAR(se().inertia.mass, 8000 * 0.05 * 100, 1e-6);
    EXPECT_THAT(outcome.out, HasSubstr("unknown"));
  }
  // Without a thickness it is no sheet; solids beside it are refused, as are cells of order 2.
  const auto said = [&](const std::string& elements, const std::string& shell) {
    folder_.write("odd.msh",
                  "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 .5 "
                  "0 0\n6 .5 .5 0\n"
                  "$EndNodes\n$Elements\n" +
                      elements + "$EndElements\n");
    const auto part = folder_.write(
        "odd.toml", "[geometry]\nfile = \"odd.msh\"\nunit = \"m\"\n" + shell +
                        "[material.steel]\nyoung = \"200 GPa\"\npoisson = 0.3\ndensity = 8000\n");
    const Outcome outcome = run("flexura-reduce", {part.string(), "-o", (folder_ / "odd.se.h5").string()});
    EXPECT_EQ(outcome.exit_code, 2);
    return outcome.err;
  };
  EXPECT_THAT(said("2\n1 2 2 8 1 1 2 3\n2 2 2 8 1 1 4 2\n", ""), HasSubstr("[shell]"));
  EXPECT_THAT(said("2\n1 2 2 8 1 1 2 3\n2 4 2 8 1 1 2 3 4\n", "[shell]\nthickness = \"1 mm\"\n"),
              HasSubstr("holds solid cells, where [shell]"));
  EXPECT_THAT(said("1\n1 9 2 8 1 1 2 3 5 6 4\n", "[shell]\nthickness = \"1 mm\"\n"),
              HasSubstr("triangles and quadrilaterals of three and four nodes do"));
}

TEST_F(Sheets, WhatIsNoSheetIsRefused) {
  const std::string rest =
      "[interface.root]\nby = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\n[modes]\ncount = 1\n";
  const auto refusal = [&](const std::string& name, const std::string& thickness,
                           const std::string& more = "") {
    const Outcome outcome = reduce(file(name) + more, rest, thickness);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(output()));
    return outcome.err;
  };
  EXPECT_THAT(refusal("sheets/square.brep", "0"), HasSubstr("thickness"));
  EXPECT_THAT(refusal("sheets/square.brep", "\"-2 mm\""), HasSubstr("thickness"));
  EXPECT_THAT(refusal("sheets/square.brep", "\"6 mm\""),
              HasSubstr("more than half the width of its faces, 5 mm"));
  EXPECT_THAT(refusal("reduce/sheet.step", "\"1 mm\""),
              HasSubstr("holds 1 solid, where [shell] wants the faces"));
  EXPECT_THAT(refusal("reduce/two_lines.brep", "\"1 mm\""), HasSubstr("holds no faces, only 2 curves"));
  EXPECT_THAT(refusal("sheets/square.brep", "\"1 mm\"", "\nfuse = true"),
              HasSubstr("geometry.fuse is for solids"));
  // A sheet without its thickness says what to give.
  const auto part = folder_.write(
      "solid.toml", fmt::format("[geometry]\n{}\n[material.steel]\nyoung = \"200 GPa\"\npoisson = "
                                "0.3\ndensity = 8000\n{}",
                                file("sheets/square.brep"), rest));
  const Outcome outcome = run("flexura-reduce", {part.string(), "-o", (folder_ / "x.se.h5").string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("is not closed"), HasSubstr("[shell]")));
}

}  // namespace
}  // namespace flexura::test
