// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Sections from files: meshed by the child process, solved, written and used by a beam part.
#include "reduce/file/section_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "beam/section/outline_stress.hpp"
#include "mbs/base/documents/document.hpp"
#include "reduce/app/section_report.hpp"
#include "reduce/file/beam_file.hpp"
#include "reduce/file/section_result.hpp"
#include "tests/beam/input_texts.hpp"

namespace flexura::reduce {
namespace {

using beam::testing::kBoxText;
using beam::testing::kChannelText;
using beam::testing::kSteelText;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class SectionFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("flexura_section_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  beam::SectionProperties solved(const std::string& text) const { return solved_alone(kSteelText + text); }
  beam::SectionProperties solved_alone(const std::string& text) const {
    SectionInput input = read_section_file(write("s.toml", text));
    input.planar.worker = FLEXURA_BIN_DIR "/flexura-mesh";
    return solve(input);
  }
  fs::path folder_;
};

TEST_F(SectionFile, PolygonWithAHoleHasItsMoments) {
  const auto s = solved(kBoxText);
  const double I_y = (0.1 * std::pow(0.2, 3) - 0.08 * std::pow(0.17, 3)) / 12;
  EXPECT_NEAR(s.area, 0.02 - 0.08 * 0.17, 1e-12);
  EXPECT_NEAR(s.I_y / I_y, 1.0, 1e-9);
  EXPECT_LT(s.shear_centre.norm(), 1e-4 * 0.2);
  // Closed: Bredt with the open part, thick walls (t/b = 0.1 to 0.15): 5 %.
  EXPECT_NEAR(s.I_t / beam::constants_of(beam::HollowRectangle{0.1, 0.2, 0.01, 0.015}, 0.3).I_t, 1.0, 0.05);
  EXPECT_FALSE(s.section.open_thin_walled);
  EXPECT_EQ(s.section.outline.size(), 2u);
  EXPECT_THAT(section_svg(s), HasSubstr("</svg>"));
}

TEST_F(SectionFile, ThinWallsMakeAChannelThatABeamPartUses) {
  const auto s = solved(kChannelText);
  // By mid-lines, h = 95, b = 47.5 mm: e = 3 b^2/(h + 6 b), I_w of Vlasov; t/b = 0.1 leaves 2 %.
  const double h = 0.095, b = 0.0475, t = 0.005;
  EXPECT_NEAR(s.area, t * (2 * b + h),
              1e-10);  // the outer corners the mitre adds equal the inner ones shared
  EXPECT_NEAR(s.shear_centre.x() / (-3 * b * b / (h + 6 * b)), 1.0, 0.02);
  EXPECT_NEAR(s.I_w / (t * b * b * b * h * h / 12 * (3 * b + 2 * h) / (6 * b + h)), 1.0, 0.03);
  EXPECT_TRUE(s.section.open_thin_walled);

  write("channel.section", section_result(s));
  const BeamPartInput part = read_beam_part(write("beam.toml", R"(
[section.channel]
type = "file"
file = "channel.section"
[node.a]
position = [0, 0, 0]
[node.b]
position = [6, 0, 0]
[member.m]
nodes = ["a", "b"]
[interface.a]
)"));
  const beam::Section& section = part.model.sections[0].section;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(section.f(i, j), s.section.f(i, j), 1e-9 * std::sqrt(section.f(i, i) * section.f(j, j)));
  EXPECT_THAT(beam::warnings(part.model, {0}).at(0), HasSubstr("open and thin-walled"));
  // A force along z at the web of a cantilever twists it by F e l/(G I_t); without the coupling it would not.
  const beam::Element element(6.0, beam::matrices_of(section, beam::Theory::timoshenko));
  const beam::Matrix6d K = element.stiffness().bottomRightCorner<6, 6>();
  const beam::Vector6d d = beam::inverse_spd(K, "end stiffness") * beam::Vector6d::Unit(2);
  EXPECT_NEAR(d(3) / (-s.shear_centre.x() * 6.0 / (s.G_ref * s.I_t)), 1.0, 1e-6);
}

TEST_F(SectionFile, PlanarFaceOfACadFileHasTheClosedFormsOfItsEllipses) {
  // Semi-axes 40 and 20 mm with a similar hole of half the size, in the plane y-z: torsion is exact for it.
  const auto s = solved_alone(std::string("cad = \"") +
                              FLEXURA_SOURCE_DIR "/tests/beam/data/ring_section.step\"\n" + kSteelText);
  const double a = 0.04, b = 0.02, pi = std::numbers::pi, hole = 1.0 - std::pow(0.5, 4);
  // Curved triangles of second order, 24 to a circle: the outline is off by (2 pi / 24)^4 / 400 or less,
  // 1e-5.
  EXPECT_NEAR(s.area / (pi * a * b * 0.75), 1.0, 1e-4);
  EXPECT_NEAR(s.I_y / (pi * a * b * b * b / 4 * hole), 1.0, 1e-4);
  EXPECT_NEAR(s.I_z / (pi * a * a * a * b / 4 * hole), 1.0, 1e-4);
  EXPECT_NEAR(s.I_t / (pi * std::pow(a * b, 3) / (a * a + b * b) * hole), 1.0, 2e-4);
  EXPECT_LT(s.shear_centre.norm(), 1e-4 * a);
  EXPECT_EQ(s.section.outline.size(), 2u);
}

TEST_F(SectionFile, CompositePliesKeepTheirFibreAngle) {
  // One ply at 30 degrees: a pull strains it by S'_xx (R. M. Jones, Mechanics of composite materials).
  const std::string carbon = R"(
[material.carbon]
density = 1600
E_1 = "140 GPa"
E_2 = "10 GPa"
E_3 = "10 GPa"
G_12 = "5 GPa"
G_13 = "5 GPa"
G_23 = "3.5 GPa"
nu_12 = 0.3
nu_13 = 0.3
nu_23 = 0.4
)";
  const auto off = solved_alone(carbon + R"(
[region.ply]
fibre_angle = "30 deg"
points = [[-50, -5], [50, -5], [50, 5], [-50, 5]]
)");
  const double c = std::cos(std::numbers::pi / 6), n = 0.5;
  const double S_xx =
      std::pow(c, 4) / 140e9 + (1 / 5e9 - 0.6 / 140e9) * c * c * n * n + std::pow(n, 4) / 10e9;
  // Uniform stress: exact but for round-off of the sparse solve.
  EXPECT_NEAR(off.section.f(beam::N, beam::N) * off.area / S_xx, 1.0, 1e-8);
  EXPECT_TRUE(off.couples);
  // A box of 0 degrees along y and 90 degrees along z as walls: flanges carry E_1, webs E_2 when it bends
  // about y.
  const auto box = solved_alone(carbon + R"(
[wall.flange_top]
thickness = "1 mm"
points = [[-30, 20], [30, 20]]
[wall.flange_bottom]
thickness = "1 mm"
points = [[-30, -20], [30, -20]]
[wall.web_left]
thickness = "1 mm"
fibre_angle = "90 deg"
points = [[-30, -20], [-30, 20]]
[wall.web_right]
thickness = "1 mm"
fibre_angle = "90 deg"
points = [[30, -20], [30, 20]]
)");
  EXPECT_FALSE(box.couples);
  EXPECT_FALSE(box.section.open_thin_walled);
  const double flanges = 140e9 * 2 * 0.06 * 0.001 * 0.02 * 0.02,
               webs = 10e9 * 2 * 0.001 * std::pow(0.04, 3) / 12;
  // By mid-lines, t/h = 1/40; what walls share at the corners belongs to the first.
  EXPECT_NEAR(1.0 / box.section.f(beam::M_y, beam::M_y) / (flanges + webs), 1.0, 0.02);
}

// All around: bending z/I_y, stretch 1/A, and torsion of the walls.
TEST_F(SectionFile, StressesAroundTheOutlineComeBack) {
  const auto s = solved(kBoxText);
  std::vector<Eigen::Matrix<double, 3, 6>> stress;
  const beam::Section read = read_section_result("box", write("box.section", section_result(s)), &stress);
  std::size_t point = 0;
  const beam::Shape shape = beam::HollowRectangle{0.1, 0.2, 0.01, 0.015};
  const beam::Constants constants = beam::constants_of(shape, 0.3);
  int n_walls = 0;
  for (const beam::Loop& loop : read.outline)
    for (Eigen::Index k = 0; k < loop.rows(); ++k, ++point) {
      const double y = loop(k, 0), z = loop(k, 1);
      ASSERT_LT(point, stress.size());
      const auto& S = stress[point];
      EXPECT_TRUE(S.isApprox(s.outline_stress[point], 1e-8));  // nine digits
      EXPECT_NEAR(S(0, beam::N) * s.area, 1.0, 1e-6);
      EXPECT_NEAR(S(0, beam::M_y), z / s.I_y, 0.01 * 0.1 / s.I_y);
      EXPECT_NEAR(S(0, beam::M_z), -y / s.I_z, 0.01 * 0.05 / s.I_z);
      // Away from corners as the standard shape's: Bredt with the open part, and the flow of shear forces.
      const bool beside = std::abs(z) < 0.06, above = std::abs(y) < 0.02;
      if (beside || above) {
        const auto standard = beam::stress_on_outline(shape, constants, y, z);
        const int row = beside ? 2 : 1;
        EXPECT_NEAR(S(row, beam::T) / standard(row, beam::T), 1.0, above ? 0.06 : 0.02);
        for (const int force : {beam::V_y, beam::V_z})
          EXPECT_NEAR(S(row, force), standard(row, force), 0.05 / (0.01 * 0.2))
              << y << " " << z << " " << force;
      }
      ++n_walls;
    }
  EXPECT_EQ(point, stress.size());
  EXPECT_GT(n_walls, 10);
}

TEST_F(SectionFile, ResultsRoundTripWithStressPointsAndAllOutlines) {
  const auto s = solved(kBoxText);
  const beam::Section read = read_section_result("box", write("box.section", section_result(s)));
  ASSERT_EQ(read.points.size(), s.section.points.size());
  for (std::size_t k = 0; k < read.points.size(); ++k) {
    EXPECT_EQ(read.points[k].name, s.section.points[k].name);
    EXPECT_TRUE(read.points[k].S.isApprox(s.section.points[k].S, 1e-15));
  }
  EXPECT_EQ(read.outline.size(), 2u);
  // Bending stress at the upper edge, M z / I; extreme fibres of a corner mesh: 1 %.
  for (const beam::StressPoint& point : read.points) {
    if (point.name == "+z") {
      EXPECT_NEAR(point.S(0, beam::M_y) / (0.1 / s.I_y), 1.0, 0.01);
    }
  }
  try {
    read_section_result("bad", write("bad.section", "I_t = 1\n"));
    FAIL() << "no refusal";
  } catch (const input::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("bad.section"));
  }
}

TEST_F(SectionFile, RefusalsAreSentences) {
  const auto refusal = [&](const std::string& text) {
    try {
      solved(text);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string("no refusal");
  };
  EXPECT_THAT(refusal(""), HasSubstr("the section has no material"));
  EXPECT_THAT(refusal("[region.a]\npoints = [[0, 0], [1, 0]]\n"), HasSubstr("a polygon has 2 corners"));
  EXPECT_THAT(refusal("[region.a]\nmaterial = \"stell\"\npoints = [[0, 0], [1, 0], [0, 1]]\n"),
              HasSubstr("did you mean \"steel\"?"));
  EXPECT_THAT(
      refusal(
          "[region.a]\npoints = [[0, 0], [1, 0], [0, 1]]\n[region.b]\npoints = [[5, 5], [6, 5], [5, 6]]\n"),
      HasSubstr("separate pieces"));
  EXPECT_THAT(
      refusal("[region.a]\npoints = [[0, 0], [1, 0], [0, 1]]\n[hole.b]\nregion = \"aa\"\npoints = [[0, 0], "
              "[0.1, 0], [0, 0.1]]\n"),
      HasSubstr("there is no such region, did you mean \"a\"?"));
  // A CAD file that holds a solid, not a face of the section.
  try {
    solved_alone(std::string("cad = \"") + FLEXURA_SOURCE_DIR "/cases/simbeam_shaft/shaft_1m.step\"\n" +
                 kSteelText);
    FAIL() << "no refusal";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("holds no face; export the section as a planar face"));
  }
  try {
    read_section_file(write("s.toml", kSteelText), {"cad=\"none.step\""});
    FAIL() << "no refusal";
  } catch (const input::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("there is no such file"));
  }
}

}  // namespace
}  // namespace flexura::reduce
