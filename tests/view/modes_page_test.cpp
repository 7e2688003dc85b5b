// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <regex>

#include "mbs/view/html/encode.hpp"
#include "mbs/view/pages.hpp"
#include "mbs/view/stress_picture.hpp"
#include "tests/view/page_reader.hpp"
#include "tests/view/synthetic.hpp"

namespace flexura::view {
namespace {

using ::testing::HasSubstr;
using testing::PageReader;
using testing::scratch;
using testing::slurp;
namespace fs = std::filesystem;

TEST(ModesPage, HoldsEveryShapeWithinHalfAQuantisationStep) {
  const auto se = synthetic::tube(24, 30, 6);
  const fs::path html = scratch("shapes.html");
  write_modes_page(html, se, synthetic::tube_modes(se));
  const PageReader page(slurp(html));
  for (int k = 0; k < 6; ++k) {
    const std::vector<double> u = page.shape("part", k);
    double largest = 0.0;
    for (Eigen::Index v = 0; v < se.surface.vertices.rows(); ++v) {
      largest = std::max(largest,
                         synthetic::tube_displacement(k, se.surface.vertices.row(v)).cwiseAbs().maxCoeff());
    }
    // Rounding to steps of largest / 32767 is off by at most half a step; the float input adds 6e-8 of its
    // value.
    const double step = largest / 32767;
    EXPECT_NEAR(page.header["surface"]["shapes"][k]["scale"].get<double>(), step, 1e-6 * step);
    for (Eigen::Index v = 0; v < se.surface.vertices.rows(); ++v) {
      const Eigen::Vector3d exact = synthetic::tube_displacement(k, se.surface.vertices.row(v));
      for (int a = 0; a < 3; ++a) {
        ASSERT_NEAR(u[static_cast<std::size_t>(3 * v + a)], exact[a], 0.5 * step + 1.2e-7 * largest)
            << k << ' ' << v;
      }
    }
  }
}

TEST(ModesPage, HoldsTheSurfaceItWasGiven) {
  const auto se = synthetic::tube(16, 10, 2);
  const fs::path html = scratch("surface.html");
  write_modes_page(html, se, synthetic::tube_modes(se));
  const PageReader page(slurp(html));
  const auto vertices = page.block<float>("part/vertices");
  ASSERT_EQ(static_cast<Eigen::Index>(vertices.size()), se.surface.vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    EXPECT_EQ(vertices[i], static_cast<float>(se.surface.vertices.data()[i]));
  }
  // Triangles may come in another order but each one as it was, with its interface.
  using Painted = std::array<std::int32_t, 4>;
  const auto triangles = page.block<std::int32_t>("part/triangles"),
             painted = page.block<std::int32_t>("part/interface");
  ASSERT_EQ(static_cast<Eigen::Index>(painted.size()), se.surface.triangles.rows());
  ASSERT_EQ(triangles.size(), 3 * painted.size());
  std::multiset<Painted> written, given;
  for (std::size_t t = 0; t < painted.size(); ++t) {
    written.insert({triangles[3 * t], triangles[3 * t + 1], triangles[3 * t + 2], painted[t]});
    const auto row = se.surface.triangles.row(static_cast<Eigen::Index>(t));
    given.insert({row[0], row[1], row[2], se.surface.triangle_interface[t]});
  }
  EXPECT_EQ(written, given);
}

// The error of the mesh at the vertices, as it came; a superelement without one has no field for it.
TEST(ModesPage, HoldsTheErrorOfTheMesh) {
  auto se = synthetic::tube(16, 10, 2);
  const fs::path html = scratch("mesh_error.html");
  write_modes_page(html, se, synthetic::tube_modes(se));
  EXPECT_FALSE(PageReader(slurp(html)).header["mesh_error"].get<bool>());
  const Eigen::VectorXf given = Eigen::VectorXf::LinSpaced(se.surface.vertices.rows(), 0.0f, 0.7f);
  se.mesh_error.emplace().at_vertices = given;
  write_modes_page(html, se, synthetic::tube_modes(se));
  const PageReader page(slurp(html));
  EXPECT_TRUE(page.header["mesh_error"].get<bool>());
  EXPECT_EQ(page.block<float>("mesh_error"), std::vector<float>(given.begin(), given.end()));
}

TEST(ModesPage, ListsFrequenciesEffectiveMassesAndInterfaces) {
  const auto se = synthetic::tube(16, 10, 4);
  const fs::path html = scratch("list.html");
  ModesPage modes = synthetic::tube_modes(se);
  write_modes_page(html, se, modes);
  const PageReader page(slurp(html));
  ASSERT_EQ(page.header["modes"].size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(page.header["modes"][k]["frequency"].get<double>(), modes.modes[k].frequency_hz);
    EXPECT_EQ(page.header["modes"][k]["effective_mass"].get<std::vector<double>>()[2],
              modes.modes[k].effective_mass[2]);
  }
  // A constraint mode has no frequency, and that is none of 0 Hz.
  modes.modes[1].vibrates = false;
  write_modes_page(html, se, modes);
  const PageReader with_constraint(slurp(html));
  for (const char* key : {"frequency", "damping", "effective_mass"}) {
    EXPECT_FALSE(with_constraint.header["modes"][1].contains(key)) << key;
    EXPECT_TRUE(with_constraint.header["modes"][2].contains(key)) << key;
  }
  EXPECT_EQ(page.header["interfaces"][1]["name"], "right end");
  EXPECT_EQ(page.header["interfaces"][1]["position"][0], synthetic::tube_length);
}

TEST(ModesPage, MacIsOneOnTheDiagonalAndZeroBetweenDirections) {
  const auto se = synthetic::tube(24, 40, 4);
  const fs::path html = scratch("mac.html");
  write_modes_page(html, se, synthetic::tube_modes(se));
  const PageReader page(slurp(html));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(page.header["mac"][i][i].get<double>(), 1.0);
  // Bending along y and along z: by symmetry of the rings orthogonal at each x, to the float's 6e-8; printed
  // to 1e-4.
  EXPECT_EQ(page.header["mac"][0][1].get<double>(), 0.0);
  EXPECT_EQ(page.header["mac"][0][3].get<double>(), 0.0);
}

TEST(ModesPage, LoadsNothingFromOutside) {
  const auto se = synthetic::tube(16, 10, 2);
  const fs::path html = scratch("contained.html");
  write_modes_page(html, se, synthetic::tube_modes(se));
  const std::string text = slurp(html);
  // Addresses occur in three's messages and licences; what must not occur is an element or a call that loads
  // one.
  EXPECT_FALSE(std::regex_search(text, std::regex("<(link|img|iframe|object|embed|base)\\b[^>]*(href|src)")));
  EXPECT_EQ(text.find("<script src"), std::string::npos);
  EXPECT_EQ(text.find("@import"), std::string::npos);
  EXPECT_FALSE(std::regex_search(text, std::regex("url\\(\\s*['\"]?https?:")));
  EXPECT_THAT(text, HasSubstr("default-src 'none'"));
  // What it brings along keeps the notices that its licences want in every copy.
  EXPECT_THAT(text, HasSubstr("Leon Sorokin (author of uPlot)"));
  EXPECT_THAT(text, HasSubstr("The above copyright notice and this permission notice shall be included"));
}

TEST(ModesPage, HundredThousandTrianglesWithThirtyModesStayUnderFifteenMegabytes) {
  auto se = synthetic::tube(250, 100, 30);
  ASSERT_GE(se.surface.triangles.rows(), 100000);
  const fs::path html = scratch("large.html");
  write_modes_page(html, se, synthetic::tube_modes(se));
  EXPECT_LT(fs::file_size(html), 15e6);
  // A smooth shape leaves deflate little; one with noise in its last 8 bits must fit as well.
  std::uint32_t state = 1;
  const float noise = 256.0f / 32767.0f / 4294967296.0f;
  for (Eigen::Index i = 0; i < se.shapes.size(); ++i) {
    state = state * 1664525u + 1013904223u;
    se.shapes.data()[i] += noise * static_cast<float>(state);
  }
  write_modes_page(html, se, synthetic::tube_modes(se));
  EXPECT_LT(fs::file_size(html), 15e6);
  RecordProperty("bytes", static_cast<int>(fs::file_size(html)));
}

TEST(ModesPage, NamesCannotBreakOutOfTheirPlace) {
  auto se = synthetic::tube(16, 10, 2);
  se.name = "</script><script>alert(1)</script>";
  se.interfaces[0].name = "<!--<script>\"&\xff";  // and a byte that is not UTF-8
  const fs::path html = scratch("names.html");
  write_modes_page(html, se, synthetic::tube_modes(se));
  const std::string text = slurp(html);
  EXPECT_EQ(text.find("<script>alert"), std::string::npos);
  EXPECT_EQ(text.find("<!--<script>\\\""), std::string::npos);
  EXPECT_EQ(PageReader(text).header["title"], se.name);
}

TEST(ModesPage, SurfaceOfSeveralPiecesFoldedAndWithLooseVerticesComesBack) {
  superelement::Superelement se;
  se.name = "pieces";
  se.n_b = 0;
  se.n_q = 1;
  // Three triangles on one edge (0 1), a separate triangle, a triangle given twice, two vertices without
  // triangle.
  se.surface.vertices.resize(11, 3);
  for (int v = 0; v < 11; ++v) se.surface.vertices.row(v) << v % 3, v / 3, 0.1 * v * v;
  se.surface.triangles.resize(6, 3);
  se.surface.triangles << 0, 1, 2, 1, 0, 3, 0, 1, 4, 6, 7, 8, 8, 7, 6, 2, 1, 9;
  se.shapes = Eigen::MatrixXf::Random(33, 1);
  ModesPage modes;
  modes.modes.resize(1);
  modes.columns = Eigen::MatrixXd::Ones(1, 1);
  const fs::path html = scratch("pieces.html");
  write_modes_page(html, se, modes);
  const std::vector<double> u = PageReader(slurp(html)).shape("part", 0);
  const double step = se.shapes.cwiseAbs().maxCoeff() / 32767.0;
  for (int i = 0; i < 33; ++i)
    EXPECT_NEAR(u[static_cast<std::size_t>(i)], se.shapes(i, 0), 0.5 * step + 1.2e-7) << i;
}

TEST(ModesPage, HoldsTheVonMisesStressOfEachMode) {
  auto se = synthetic::tube(24, 30, 6);
  synthetic::add_stress(se);
  const fs::path html = scratch("stress.html");
  write_modes_page(html, se, synthetic::tube_modes(se));
  const PageReader page(slurp(html));
  EXPECT_EQ(page.header["surface"]["stress"], 1);
  for (int k = 0; k < 6; ++k) {
    const std::vector<double> sigma = page.field("part", "stress", k, 1);
    const Eigen::VectorXd exact =
        se.stress->S.col(12 + k)(Eigen::seq(0, Eigen::last, Eigen::fix<6>)).cwiseAbs();
    // Half a step of largest / 1023; the writer's 32-bit input adds 6e-8 of the value.
    for (Eigen::Index v = 0; v < exact.size(); ++v) {
      ASSERT_NEAR(sigma[static_cast<std::size_t>(v)], exact[v], (0.5 / 1023 + 1.2e-7) * exact.maxCoeff())
          << k;
    }
  }
}

TEST(StressField, IsVonMisesWhereStressModesAreAndNothingElsewhereOrForRigidMotion) {
  auto se = synthetic::tube(16, 10, 2);
  superelement::StressModes& stress = se.stress.emplace();
  for (std::int32_t v = 0; v < se.surface.vertices.rows(); v += 3) stress.vertices.push_back(v);
  stress.S.setZero(6 * static_cast<Eigen::Index>(stress.vertices.size()), se.n());
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(stress.vertices.size()); ++s) {
    stress.S.block<6, 1>(6 * s, 12) << 1e6, 2e6, -1e6, 3e5, 0.0, 1e5;
    stress.S(6 * s, 0) = 1e9;  // two shapes whose sum is a rigid motion
    stress.S(6 * s, 6) = -1e9 * (1.0 + 1e-14);
  }
  const StressField field(se);
  Eigen::VectorXd u_se = Eigen::VectorXd::Zero(se.n());
  u_se[12] = -1.0;
  const Eigen::VectorXf sigma = field.von_mises(u_se);
  // ((1e6)^2 + (3e6)^2 + (2e6)^2) / 2 + 3 (9e10 + 1e10), in 32 bits.
  const double exact = std::sqrt(7e12 + 3e11);
  for (Eigen::Index v = 0; v < sigma.size(); ++v)
    EXPECT_NEAR(sigma[v], v % 3 == 0 ? exact : 0.0, 1e-6 * exact);
  u_se.setZero();
  u_se[0] = u_se[6] = 1.0;
  EXPECT_EQ(field.von_mises(u_se).maxCoeff(), 0.0f);
}

std::string refusal(const fs::path& html, const superelement::Superelement& se, const ModesPage& modes) {
  try {
    write_modes_page(html, se, modes);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST(ModesPage, RefusesWhatItCannotDrawAndLeavesNoFile) {
  const auto good = synthetic::tube(16, 10, 2);
  const ModesPage modes = synthetic::tube_modes(good);
  const fs::path html = scratch("refused.html");
  auto se = good;
  se.surface.vertices.resize(0, 3);
  EXPECT_THAT(refusal(html, se, modes), HasSubstr("superelement 'tube' holds no surface to draw"));
  se = good;
  se.surface.triangles(3, 1) = 9999;
  EXPECT_THAT(refusal(html, se, modes), HasSubstr("refer to vertices 0 to 9999"));
  se = good;
  se.shapes(5, 13) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal(html, se, modes), HasSubstr("not finite"));
  ModesPage short_list = modes;
  short_list.columns.resize(3, 2);
  short_list.columns.setZero();
  EXPECT_THAT(refusal(html, good, short_list), HasSubstr("must be 14 x 2, but they are 3 x 2"));
  EXPECT_FALSE(fs::exists(html));
  EXPECT_FALSE(fs::exists(html.string() + ".part"));
  EXPECT_THAT(refusal("/nowhere/page.html", good, modes),
              HasSubstr("/nowhere/page.html: the folder /nowhere does not exist; make it first"));
}

}  // namespace
}  // namespace flexura::view
