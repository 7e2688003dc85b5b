// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Sections from files: meshed by the child process, solved, written and used by a beam part.
#include "reduce/app/section_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "mbs/input/document.hpp"
#include "reduce/app/beam_file.hpp"

namespace flexura::reduce {
namespace {

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
  beam::SectionProperties solved(const std::string& text) const {
    SectionInput input = read_section_file(write("s.toml", kSteel + text));
    input.planar.worker = FLEXURA_BIN_DIR "/flexura-mesh";
    return solve(input);
  }
  fs::path folder_;
  const std::string kSteel = R"(
[material.steel]
young = "210 GPa"
poisson = 0.3
density = "7850 kg/m^3"
)";
};

TEST_F(SectionFile, PolygonWithAHoleHasItsMoments) {
  const auto s = solved(R"(
[region.box]
points = [[-50, -100], [50, -100], [50, 100], [-50, 100]]
[hole.inside]
region = "box"
points = [[-40, -85], [40, -85], [40, 85], [-40, 85]]
)");
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
  const auto s = solved(R"(
[wall.profile]
thickness = "5 mm"
points = [[47.5, -47.5], [0, -47.5], [0, 47.5], [47.5, 47.5]]
)");
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
  try {
    read_section_file(write("s.toml", kSteel), {"cad=\"none.step\""});
    FAIL() << "no refusal";
  } catch (const input::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("there is no such file"));
  }
}

}  // namespace
}  // namespace flexura::reduce
