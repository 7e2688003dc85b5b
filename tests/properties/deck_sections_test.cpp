// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every section of *BEAM SECTION: area, moments and the place of the centroid from the nodes are those of the figure, whatever
// program the deck was written for; a guess between the two is told. Old and short cards of Nastran mean what the long ones do.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "mesh/import/abaqus.hpp"
#include "mesh/import/nastran.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using mbs::chance::Chance;
using ::testing::AllOf;
using ::testing::HasSubstr;

class DeckSections : public mbs::test::TestFolder {
 protected:
  ImportedModel abaqus(const std::string& section, const std::string& type = "B31",
                       const std::string& more = "") const {
    return read_abaqus(file("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0.5, 0, 0\n*ELEMENT, TYPE=" + type +
                                (type[2] == '2' ? ", ELSET=E\n1, 1, 3, 2\n" : ", ELSET=E\n1, 1, 2\n") +
                                "*MATERIAL, NAME=M\n*ELASTIC\n2.1E11, 0.3\n*DENSITY\n7850\n" + section + more,
                            "deck.inp"));
  }
  ImportedModel nastran(const std::string& cards) const {
    return read_nastran(file("BEGIN BULK\n" + cards + "ENDDATA\n", "deck.bdf"));
  }
};

// By strips along 1, each from low(x) to high(x) along 2.  4000 strips: the ends of an ellipse, where its outline stands upright, leave
// (1 / 4000)^1.5 of the area.
struct Figure {
  double A = 0, I_11 = 0, I_22 = 0;  ///< about the axes 1 (int x_2^2) and 2 through the centroid
  Vector2d centroid = Vector2d::Zero();
};
template <class Low, class High>
Figure by_strips(double from, double to, const Low& low, const High& high) {
  constexpr int n = 4000;
  Figure f;
  double S_11 = 0, S_22 = 0;
  const double dx = (to - from) / n;
  for (int k = 0; k < n; ++k) {
    const double x = from + (k + 0.5) * dx, a = low(x), b = high(x);
    f.A += (b - a) * dx;
    f.centroid += Vector2d(x * (b - a), 0.5 * (b * b - a * a)) * dx;
    S_11 += (b * b * b - a * a * a) / 3 * dx;
    S_22 += (x * x + dx * dx / 12) * (b - a) * dx;
  }
  f.centroid /= f.A;
  f.I_11 = S_11 - f.A * f.centroid.y() * f.centroid.y();
  f.I_22 = S_22 - f.A * f.centroid.x() * f.centroid.x();
  return f;
}

void expect_figure(const ImportedBar& bar, const Figure& f, const Vector2d& centroid, double tolerance) {
  EXPECT_NEAR(bar.A / f.A, 1.0, tolerance);
  EXPECT_NEAR(bar.I_yy / f.I_11, 1.0, tolerance);
  EXPECT_NEAR(bar.I_zz / f.I_22, 1.0, tolerance);
  EXPECT_LE((bar.centroid - centroid).norm(), tolerance * std::sqrt(f.A));
}

TEST_F(DeckSections, OfCalculixAreThicknessesAndStandOffByTheirOffsets) {
  int guessed = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const double t_1 = std::pow(10.0, chance.between(-3.0, 1.0)), ratio = chance.between(0.3, 3.0);
    const bool is_circle = chance.flip(0.7), has_two = !is_circle || chance.flip(0.5);
    const double t_2 = has_two ? t_1 * ratio : t_1;
    const std::string type = chance.flip(0.5) ? "B31" : chance.flip(0.5) ? "B32R" : "B32";
    std::string text =
        fmt::format("*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION={}", is_circle ? "CIRC" : "RECT");
    Vector2d offset = Vector2d::Zero();
    const char* const keys[] = {"OFFSET1", "OFFSET2"};
    for (int k = 0; k < 2; ++k)
      if (chance.flip(0.4)) {
        offset[k] = chance.between(-2.0, 2.0);
        text += fmt::format(", {}={:.15g}", keys[k], offset[k]);
      }
    text += has_two ? fmt::format("\n{:.15g}, {:.15g}\n0, 1, 0\n", t_1, t_2)
                    : fmt::format("\n{:.15g}\n0, 1, 0\n", t_1);
    const bool output = chance.flip(0.2);
    const ImportedModel model =
        abaqus(text, type, output ? "*STEP\n*STATIC\n*NODE FILE, OUTPUT=2D\nU\n*END STEP\n" : "");
    const auto half = [&](double x) {
      return is_circle ? 0.5 * t_2 * std::sqrt(std::max(0.0, 1.0 - 4.0 * x * x / (t_1 * t_1))) : 0.5 * t_2;
    };
    const Figure figure = by_strips(
        -0.5 * t_1, 0.5 * t_1, [&](double x) { return -half(x); }, half);
    // The nodes stand `offset` thicknesses from the axis (CalculiX, gen3dfrom1d.f).
    for (const ImportedBar& bar : model.bars)
      expect_figure(bar, figure, Vector2d(-offset.x() * t_1, -offset.y() * t_2), 1e-4);
    const bool tells = has_two || offset.norm() > 0 || type == "B32R" || output;
    if (is_circle && !tells) {
      ++guessed;
      EXPECT_THAT(model.warnings,
                  ::testing::Contains(AllOf(HasSubstr("diameter"), HasSubstr("geometry.program"))));
    } else {
      EXPECT_TRUE(model.warnings.empty()) << fmt::format("{}", fmt::join(model.warnings, "\n"));
    }
  }
  EXPECT_GT(guessed, 5);
}

TEST_F(DeckSections, OfAbaqusHaveTheirNodeAnywhereAndFlangesThatMayBeMissing) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const double h = chance.between(0.05, 0.3), web = chance.between(0.05, 0.1) * h;
    double width[2], thickness[2];
    const int missing = chance.below(3);  // 2: none
    for (int k = 0; k < 2; ++k) {
      width[k] = k == missing ? 0.0 : chance.between(0.3, 1.0) * h;
      thickness[k] = k == missing ? 0.0 : chance.between(0.05, 0.2) * h;
    }
    const double l = chance.flip(0.3) ? 0.0 : chance.between(-0.5, 1.5) * h;
    const ImportedModel model = abaqus(fmt::format(
        "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=I\n{:.15g}, {:.15g}, {:.15g}, {:.15g}, {:.15g}, "
        "{:.15g}, {:.15g}\n0, 1, 0\n",
        l, h, width[0], width[1], thickness[0], thickness[1], web));
    // Three rectangles, from the lower edge.
    const double w[] = {width[0], web, width[1]},
                 height[] = {thickness[0], h - thickness[0] - thickness[1], thickness[1]};
    double A = 0, S = 0, I_11 = 0, I_22 = 0, at = 0;
    for (int k = 0; k < 3; ++k) {
      const double a = w[k] * height[k], z = at + 0.5 * height[k];
      A += a, S += a * z, I_11 += a * (height[k] * height[k] / 12 + z * z), I_22 += a * w[k] * w[k] / 12;
      at += height[k];
    }
    const Figure figure{A, I_11 - S * S / A, I_22, Vector2d::Zero()};
    ASSERT_EQ(model.bars.size(), 1U);
    expect_figure(model.bars[0], figure, Vector2d(0.0, S / A - l), 1e-9);  // round-off of differences
    EXPECT_TRUE(model.warnings.empty());
  }
}

// A circle of a deck of Abaqus has its radius.
TEST_F(DeckSections, WhatADeckTellsOfItsProgramDecides) {
  const std::string circle = "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=CIRC\n0.01\n0, 1, 0\n";
  const double A = std::numbers::pi * 1e-4;
  for (const char* const told : {"*PREPRINT, ECHO=NO\n", "*STEP\n*STATIC\n*OUTPUT, FIELD\n*END STEP\n"}) {
    const ImportedModel model = abaqus(circle, "B31", told);
    EXPECT_NEAR(model.bars[0].A / A, 1.0, 1e-12);
    EXPECT_TRUE(model.warnings.empty());
  }
  EXPECT_NEAR(abaqus(circle, "B33").bars[0].A / A, 1.0, 1e-12);
  abaqus(circle);
  EXPECT_NEAR(read_abaqus(folder_ / "deck.inp", DeckProgram::abaqus).bars[0].A / A, 1.0, 1e-12);
  const ImportedModel asked = read_abaqus(folder_ / "deck.inp", DeckProgram::calculix);
  EXPECT_NEAR(asked.bars[0].A / A, 0.25, 1e-12);
  EXPECT_TRUE(asked.warnings.empty());
  for (const char* const wrong : {"SECTION=CIRC\n-0.01", "SECTION=CIRC\n0.01, -0.02", "SECTION=CIRC\n0",
                                  "SECTION=I\n0, 0, 0.06, 0, 0.01, 0, 0.003", "SECTION=RECT\n0.01, 0",
                                  "SECTION=I\n0, 0.1, 0, 0, 0, 0, 0.003"})
    EXPECT_THROW(abaqus(fmt::format("*BEAM SECTION, ELSET=E, MATERIAL=M, {}\n0, 1, 0\n", wrong)),
                 std::invalid_argument)
        << wrong;
}

TEST_F(DeckSections, OldFlagsOfOrientationAndModuliThatAreLeftOutMeanWhatNastranSays) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const Vector3d x_2 = chance.direction(), v = chance.direction();
    if (x_2.cross(v).norm() < 0.1) continue;
    const bool by_grid = chance.flip(0.5);
    const double E = chance.between(1e9, 4e11), nu = chance.between(0.0, 0.45);
    const auto deck = [&](const std::string& flag, const std::string& moduli) {
      return nastran(
          fmt::format("MAT1,1,{}\n,,,,\nGRID,1,,0.,0.,0.\nGRID,2,,{:.5f},{:.5f},{:.5f}\nGRID,3,,{:.5f},"
                      "{:.5f},{:.5f}\nPBARL,1,1,,BAR\n,0.03,0.05\nCBAR,1,1,1,2,{},{}\n",
                      moduli, x_2.x(), x_2.y(), x_2.z(), v.x(), v.y(), v.z(),
                      by_grid ? "3,," : fmt::format("{:.5f},{:.5f},{:.5f}", v.x(), v.y(), v.z()), flag));
    };
    const ImportedModel plain = deck("", fmt::format("{:.6g},,{:.6g},7850.", E, nu)),
                        old = deck(by_grid ? "2" : "1", fmt::format("{:.6g},,,7850.", E));
    ASSERT_EQ(old.bars.size(), 1U);
    EXPECT_EQ(old.bars[0].orientation, plain.bars[0].orientation);
    EXPECT_EQ(old.materials[0].E, plain.materials[0].E);
    EXPECT_EQ(old.materials[0].nu, 0.0);
    EXPECT_THAT(old.warnings, ::testing::Contains(HasSubstr("MAT1 of E alone")));
    EXPECT_TRUE(plain.warnings.empty());
  }
  for (const char* const moduli : {",8e10,,7850.", ",,0.3,7850.", ",,,7850."})
    EXPECT_THROW(nastran(fmt::format("MAT1,1,{}\nGRID,1,,0.,0.,0.\n", moduli)), std::invalid_argument)
        << moduli;
}

}  // namespace
}  // namespace flexura::mesh
