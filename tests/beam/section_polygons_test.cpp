// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Polygons of section files: which bound an area, and what is left where holes reach over edges and over each other.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "beam/section/section_mesh.hpp"
#include "mbs/base/documents/document.hpp"
#include "reduce/file/polygon.hpp"
#include "reduce/file/section_file.hpp"
#include "tests/beam/input_texts.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Vector2d;
using mbs::chance::Chance;
using mesh::PlaneLoop;
using ::testing::HasSubstr;

class SectionPolygons : public mbs::test::TestFolder {
 protected:
  SectionInput input(const std::string& text) const {
    SectionInput section = read_section_file(file(text + beam::testing::kSteelText, "s.toml"));
    section.planar.worker = FLEXURA_BIN_DIR "/flexura-mesh";
    return section;
  }
};

double area_of(const PlaneLoop& p) {  // Gauss
  double twice = 0;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const auto &a = p[k], &b = p[(k + 1) % p.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * std::abs(twice);
}

/// Corners around a centre at rising angles less than a half turn apart: simple.
PlaneLoop star(Chance& chance, int n, double size, const Vector2d& centre) {
  PlaneLoop loop;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * std::numbers::pi * (k + chance.between(0.0, 0.6)) / n,
                 r = size * chance.between(0.3, 1.0);
    loop.push_back({centre.x() + r * std::cos(angle), centre.y() + r * std::sin(angle)});
  }
  return loop;
}

/// The part of a polygon on the left of each side of a convex one (Sutherland and Hodgman, 1974).
PlaneLoop clipped(PlaneLoop p, const PlaneLoop& convex) {
  for (std::size_t k = 0; k < convex.size() && !p.empty(); ++k) {
    const Vector2d a(convex[k][0], convex[k][1]),
        b(convex[(k + 1) % convex.size()][0], convex[(k + 1) % convex.size()][1]);
    const auto left = [&](const std::array<double, 2>& x) {
      return (b.x() - a.x()) * (x[1] - a.y()) - (b.y() - a.y()) * (x[0] - a.x());
    };
    PlaneLoop out;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const auto &from = p[i], &to = p[(i + 1) % p.size()];
      const double f = left(from), t = left(to);
      if (f >= 0) out.push_back(from);
      if ((f >= 0) != (t >= 0)) {
        const double s = f / (f - t);
        out.push_back({from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1])});
      }
    }
    p = out;
  }
  return p;
}

TEST_F(SectionPolygons, ShareTheAreaThatClippingLeavesOfThem) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Chance chance(seed);
    const PlaneLoop any = star(chance, 3 + chance.below(9), 0.05, Vector2d::Zero());
    PlaneLoop convex;  // corners on an ellipse
    const double a = chance.between(0.01, 0.05), b = chance.between(0.01, 0.05),
                 x = chance.between(-0.06, 0.06);
    const int n = 3 + chance.below(6);
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * std::numbers::pi * (k + chance.between(0.0, 0.5)) / n;
      convex.push_back({x + a * std::cos(angle), b * std::sin(angle)});
    }
    ASSERT_EQ(polygon_fault(any), "") << seed;
    // Sums of some hundred terms of the size of the polygons.
    EXPECT_NEAR(shared_area(any, convex), area_of(clipped(any, convex)), 1e-14) << seed;
    EXPECT_NEAR(shared_area(any, any), area_of(any), 1e-14) << seed;
  }
}

TEST_F(SectionPolygons, ThatCrossTouchOrFoldBoundNoArea) {
  const auto turn = [](const std::array<double, 2>& a, const std::array<double, 2>& b,
                       const std::array<double, 2>& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0;
  };
  int crossing = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Chance chance(seed);
    PlaneLoop loop;  // corners anywhere
    const int n = 4 + chance.below(4);
    for (int k = 0; k < n; ++k) loop.push_back({chance.between(0.0, 1.0), chance.between(0.0, 1.0)});
    bool crosses = false;
    for (int i = 0; i < n; ++i)
      for (int j = i + 2; j < n; ++j) {
        if (i == 0 && j == n - 1) continue;
        const auto &a = loop[static_cast<std::size_t>(i)], &b = loop[static_cast<std::size_t>(i + 1)],
                   &c = loop[static_cast<std::size_t>(j)], &d = loop[static_cast<std::size_t>((j + 1) % n)];
        crosses = crosses || (turn(a, b, c) != turn(a, b, d) && turn(c, d, a) != turn(c, d, b));
      }
    crossing += crosses;
    EXPECT_EQ(!polygon_fault(loop).empty(), crosses) << seed;
  }
  EXPECT_GT(crossing, 100);
  EXPECT_LT(crossing, 290);
  const PlaneLoop square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  EXPECT_EQ(polygon_fault(square), "");
  EXPECT_EQ(without_repeated({{0, 0}, {1, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}, true), square);
  EXPECT_THAT(polygon_fault({{0, 0}, {1, 0}, {1, 1}, {0.5, 0}, {0, 1}}), HasSubstr("touches itself"));
  EXPECT_THAT(polygon_fault({{0, 0}, {2, 0}, {1, 0}, {1, 1}}), HasSubstr("folds back on itself at corner 2"));
  EXPECT_THAT(polygon_fault({{0, 0}, {1, 0}, {2, 0}}), HasSubstr("folds back"));
  EXPECT_THAT(polygon_fault({{0, 0}, {1, 0}}), HasSubstr("has 2 corners; at least 3"));
  // A ring as one polygon walks its bridge twice.
  EXPECT_THAT(polygon_fault({{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}}),
              HasSubstr("touches itself"));
}

// Rectangles on a grid of 1 mm: what is left is counted in its cells.  Each fourth plate is meshed (0.2 s), and what is none.
TEST_F(SectionPolygons, LoseWhatHolesCoverWhereverTheseLie) {
  constexpr int n = 8;
  int solved = 0;
  std::set<std::string> ends;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    bool full[n][n];
    for (auto& row : full) std::ranges::fill(row, true);
    std::string text =
        fmt::format("size = \"4 mm\"\n[region.a]\npoints = [[0, 0], [{0}, 0], [{0}, {0}], [0, {0}]]\n", n);
    bool outside = false, whole = false;
    for (int h = 1 + chance.below(3); h > 0; --h) {
      const int y = chance.below(n + 3) - 2, z = chance.below(n + 3) - 2,
                w = 1 + chance.below(chance.flip(0.3) ? 11 : 3),
                t = 1 + chance.below(chance.flip(0.3) ? 11 : 3);
      text += fmt::format(
          "[hole.h{0}]\nregion = \"a\"\npoints = [[{1}, {2}], [{3}, {2}], [{3}, {4}], [{1}, {4}]]\n", h, y, z,
          y + w, z + t);
      whole = whole || (y <= 0 && z <= 0 && y + w >= n && z + t >= n);
      outside = outside || y + w <= 0 || z + t <= 0 || y >= n || z >= n;
      for (int i = std::max(y, 0); i < std::min(y + w, n); ++i)
        for (int j = std::max(z, 0); j < std::min(z + t, n); ++j) full[i][j] = false;
    }
    int count = 0, pieces = 0;
    double I_zz = 0;  // int y^2
    bool seen[n][n] = {};
    const auto fill = [&](const auto& self, int i, int j) -> void {
      if (i < 0 || j < 0 || i >= n || j >= n || !full[i][j] || seen[i][j]) return;
      seen[i][j] = true;
      self(self, i + 1, j), self(self, i - 1, j), self(self, i, j + 1), self(self, i, j - 1);
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        if (!full[i][j]) continue;
        ++count;
        I_zz += (i + 0.5) * (i + 0.5) + 1.0 / 12;
        if (!seen[i][j]) ++pieces, fill(fill, i, j);
      }
    bool pinched = false;
    for (int i = 0; i + 1 < n; ++i)
      for (int j = 0; j + 1 < n; ++j)
        pinched = pinched || (full[i][j] == full[i + 1][j + 1] && full[i + 1][j] == full[i][j + 1] &&
                              full[i][j] != full[i + 1][j]);
    const bool is_meshed = seed % 4 == 0 || pieces != 1 || pinched;
    beam::SectionMesh mesh;
    const std::string said = mbs::test::refusal_of([&] {
      const SectionInput section = input(text);
      if (!is_meshed) return;
      const mesh::PlanarMesh planar = mesh::mesh_planar(section.planar);
      mesh = {planar.points, planar.triangles, planar.region, {}};
      beam::check_section_mesh("s", mesh, section.plies);
    });
    const std::string want = outside      ? "it cuts nothing out"
                             : whole      ? "leaves nothing of region.a"
                             : !is_meshed ? "accepted"
                             : count == 0 ? "has no area"
                             : pieces > 1 ? "separate pieces"
                             : pinched    ? "touch in a single point"
                                          : "accepted";
    ASSERT_THAT(said, HasSubstr(want)) << text;
    ends.insert(want);
    if (!is_meshed || said != "accepted") continue;
    ++solved;
    double area = 0, second = 0;  // straight sides: by the three mid-sides, exact for squares of y
    for (Eigen::Index c = 0; c < mesh.triangles.rows(); ++c) {
      const auto at = [&](int k) { return Vector2d(mesh.points.row(mesh.triangles(c, k)).transpose()); };
      const Vector2d p = at(1) - at(0), q = at(2) - at(0);
      const double own = 0.5 * (p.x() * q.y() - p.y() * q.x());
      area += own;
      for (int k = 3; k < 6; ++k) second += own / 3 * at(k).x() * at(k).x();
    }
    // Coordinates pass the kernel in mm with their 1e-7 mm of tolerance.
    EXPECT_NEAR(area, count * 1e-6, 1e-12) << text;
    EXPECT_NEAR(second, I_zz * 1e-12, 1e-17) << text;
  }
  EXPECT_GT(solved, 15);
  EXPECT_GE(ends.size(), 4u);
}

TEST_F(SectionPolygons, OfEveryKindThatIsNoneAreRefusedByName) {
  const std::string square = "[region.a]\npoints = [[0, 0], [10, 0], [10, 10], [0, 10]]\n";
  const auto refusal = [&](const std::string& text) {
    return mbs::test::refusal_of([&] { solve(input(text)); });
  };
  EXPECT_THAT(refusal("[region.bow]\npoints = [[0, 0], [10, 10], [10, 0], [0, 12]]\n"),
              testing::AllOf(HasSubstr("region.bow.points"), HasSubstr("crosses or touches itself")));
  EXPECT_THAT(refusal(square + "[hole.h]\nregion = \"a\"\npoints = [[2, 2], [4, 4], [4, 2], [2, 4]]\n"),
              HasSubstr("hole.h.points"));
  EXPECT_THAT(refusal("[wall.w]\nthickness = \"1 mm\"\npoints = [[0, 0], [20, 0], [10, 0]]\n"),
              HasSubstr("folds back on itself at (20, 0)"));
  EXPECT_THAT(refusal("[region.a]\npoints = [[0, 0], [1e30, 0], [0, 1e30]]\n"), HasSubstr("must be below"));
  EXPECT_THAT(refusal(square + "[region.b]\npoints = [[10, 10], [20, 10], [20, 20], [10, 20]]\n"),
              HasSubstr("separate pieces"));
  EXPECT_THAT(refusal("size = \"1 um\"\n" + square),
              testing::AllOf(HasSubstr("some 2.31e+08 triangles"), HasSubstr("give a size of")));
  EXPECT_THAT(refusal("[wall.w]\nthickness = \"1 um\"\npoints = [[0, 0], [1000, 0]]\n"),
              HasSubstr("is too thin for its length"));
  EXPECT_EQ(refusal("[region.a]\npoints = [[0, 0], [10, 0], [10, 0], [10, 10], [0, 10], [0, 0]]\n"),
            "accepted");
}

TEST_F(SectionPolygons, TooCoarseASizeIsBoundedAndToldAndSoAreSlips) {
  const auto told = [&](const std::string& text) {
    std::vector<std::string> warnings;
    const double I_t = solve(input(text), &warnings).I_t;
    return std::pair{I_t, warnings};
  };
  const std::string square = "[region.a]\npoints = [[0, 0], [20, 0], [20, 20], [0, 20]]\n";
  const auto [fine, none] = told(square);
  EXPECT_TRUE(none.empty());
  const auto [coarse, warnings] = told("size = \"1 km\"\n" + square);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("coarser than half of the section's mean thickness"));
  // Timoshenko, Goodier, Theory of Elasticity: 0.1406 a^4.
  EXPECT_NEAR(coarse / (0.1406 * std::pow(0.02, 4)), 1.0, 0.01);
  EXPECT_NEAR(fine / (0.1406 * std::pow(0.02, 4)), 1.0, 0.001);
  const auto [unused, lost] = told(square + "[region.core]\npoints = [[2, 2], [4, 2], [4, 4], [2, 4]]\n");
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_THAT(lost[0], HasSubstr("region.core adds nothing"));
}

}  // namespace
}  // namespace flexura::reduce
