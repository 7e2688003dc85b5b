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
