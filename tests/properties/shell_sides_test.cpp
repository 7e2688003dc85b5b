// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every sheet of shells: however its cells are numbered, they are pushed from one side, the one that is asked for or that most of
// them have; their vector area is that of the rim.
#include "mesh/model/shell_sides.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "tests/mbs/random/chance.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Vector3d;
using mbs::chance::Chance;
using ::testing::HasSubstr;

using Cells = std::vector<std::vector<Index>>;

Mesh shells(const std::vector<Vector3d>& points, const Cells& cells) {
  Mesh mesh;
  mesh.points.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t k = 0; k < points.size(); ++k)
    mesh.points.row(static_cast<Eigen::Index>(k)) = points[k].transpose();
  for (const std::size_t corners : {3U, 4U}) {
    CellBlock block{.type = corners == 3 ? CellType::tri3 : CellType::quad4};
    std::vector<const std::vector<Index>*> own;
    for (const auto& cell : cells)
      if (cell.size() == corners) own.push_back(&cell);
    block.nodes.resize(static_cast<Eigen::Index>(own.size()), static_cast<Eigen::Index>(corners));
    for (std::size_t row = 0; row < own.size(); ++row)
      for (std::size_t k = 0; k < corners; ++k)
        block.nodes(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k)) = (*own[row])[k];
    if (!own.empty()) mesh.shells.push_back(std::move(block));
  }
  return mesh;
}

// Of a polygon, also a bent one: half the sum over its sides of r x dr.
Vector3d vector_area(const Mesh& mesh, const std::vector<CellBlock>& blocks) {
  Vector3d sum = Vector3d::Zero();
  for (const CellBlock& block : blocks)
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row)
      for (Eigen::Index k = 0; k < block.nodes.cols(); ++k) {
        const Vector3d a = mesh.points.row(block.nodes(row, k)),
                       b = mesh.points.row(block.nodes(row, (k + 1) % block.nodes.cols()));
        sum += 0.5 * a.cross(b);
      }
  return sum;
}

Vector3d pushed(const Mesh& mesh, const std::optional<Vector3d>& side) {
  const ShellSides sides = shells_of_one_side(mesh, mesh.shells, side);
  return vector_area(mesh, cells_where(mesh.shells, sides, false)) -
         vector_area(mesh, cells_where(mesh.shells, sides, true));
}

struct Sheet {
  std::vector<Vector3d> points;
  Cells cells;  ///< all of one side, before any is turned
  Vector3d rim = Vector3d::Zero();
};

// A bent sheet of nx x ny cells, quadrilaterals and pairs of triangles.
Sheet random_sheet(Chance& chance) {
  Sheet s;
  const int nx = 2 + chance.below(6), ny = 2 + chance.below(6);
  const double bend_x = chance.between(-1.0, 1.0), bend_y = chance.between(-1.0, 1.0);
  const Eigen::Matrix3d R = chance.rotation();
  const Vector3d t = chance.vector(3.0);
  const auto node = [&](int i, int j) { return static_cast<Index>(j * (nx + 1) + i); };
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const double x = static_cast<double>(i) / nx, y = static_cast<double>(j) / ny;
      s.points.push_back(t + R * Vector3d(x, y, bend_x * x * x + bend_y * y * y * x));
    }
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const Index a = node(i, j), b = node(i + 1, j), c = node(i + 1, j + 1), d = node(i, j + 1);
      if (chance.flip(0.5)) {
        s.cells.push_back({a, b, c, d});
      } else {
        s.cells.push_back({a, b, c});
        s.cells.push_back({a, c, d});
      }
    }
  std::vector<Index> rim;
  for (int i = 0; i < nx; ++i) rim.push_back(node(i, 0));
  for (int j = 0; j < ny; ++j) rim.push_back(node(nx, j));
  for (int i = nx; i > 0; --i) rim.push_back(node(i, ny));
  for (int j = ny; j > 0; --j) rim.push_back(node(0, j));
  for (std::size_t k = 0; k < rim.size(); ++k)
    s.rim += 0.5 * s.points[static_cast<std::size_t>(rim[k])].cross(
                       s.points[static_cast<std::size_t>(rim[(k + 1) % rim.size()])]);
  return s;
}

TEST(ShellSides, AreOneHoweverTheCellsAreNumbered) {
  int refused = 0, repaired = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const Sheet sheet = random_sheet(chance);
    const double share = chance.between(0.0, 1.0);
    Cells cells = sheet.cells;
    for (auto& cell : cells) {
      if (chance.flip(share)) std::reverse(cell.begin(), cell.end());
      std::rotate(cell.begin(), cell.begin() + chance.below(static_cast<int>(cell.size())), cell.end());
    }
    for (std::size_t k = cells.size(); k > 1; --k)
      std::swap(cells[k - 1], cells[static_cast<std::size_t>(chance.below(static_cast<int>(k)))]);
    const Mesh mesh = shells(sheet.points, cells);
    // Sums of as many products of coordinates of up to 5 m.
    const double round_off = 1e-13 * 25.0 * static_cast<double>(cells.size());
    Vector3d side = chance.direction();
    if (std::abs(side.dot(sheet.rim.normalized())) < 0.1) side = sheet.rim.normalized();
    const Vector3d wanted = side.dot(sheet.rim) > 0 ? sheet.rim : Vector3d(-sheet.rim);
    EXPECT_LT((pushed(mesh, side) - wanted).norm(), round_off);
    EXPECT_LT((pushed(mesh, Vector3d(-3.0 * side)) + wanted).norm(), round_off);
    // Without a side that of three quarters of the area counts.
    double area = 0.0, turned = 0.0;
    for (const auto& cell : cells) {
      const Mesh one = shells(sheet.points, {cell});
      const Vector3d a = vector_area(one, one.shells);
      // Vector areas of the sheet's cells all look to the side of the rim's: it bends by less than a right angle.
      area += a.norm();
    }
    const Mesh plain = shells(sheet.points, sheet.cells);
    const ShellSides numbered = shells_of_one_side(mesh, mesh.shells, sheet.rim);
    for (std::size_t b = 0; b < mesh.shells.size(); ++b)
      for (Eigen::Index row = 0; row < mesh.shells[b].nodes.rows(); ++row)
        if (numbered.turned[b][static_cast<std::size_t>(row)] != 0) {
          std::vector<Index> corners;
          for (const Index node : mesh.shells[b].nodes.row(row)) corners.push_back(node);
          const Mesh one = shells(sheet.points, {corners});
          turned += vector_area(one, one.shells).norm();
        }
    if (std::abs(std::min(turned, area - turned) - 0.25 * area) < 1e-9 * area) continue;
    if (std::min(turned, area - turned) > 0.25 * area) {
      EXPECT_THAT(mbs::test::refusal_of([&] { pushed(mesh, {}); }), HasSubstr("side = [x, y, z]"));
      ++refused;
    } else {
      EXPECT_LT((pushed(mesh, {}) - (turned < 0.5 * area ? sheet.rim : Vector3d(-sheet.rim))).norm(),
                round_off);
      repaired += turned > 0.0 && turned < area;
    }
    EXPECT_LT((pushed(plain, {}) - sheet.rim).norm(), round_off);
  }
  EXPECT_GT(refused, 50);
  EXPECT_GT(repaired, 50);
}

TEST(ShellSides, OfAClosedShellIsTheOuterOneAndAMoebiusStripHasNone) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    // An octahedron, stretched and turned: each face looks away from the middle.
    const Eigen::Matrix3d R = chance.rotation();
    const Vector3d scale(chance.between(0.5, 2.0), chance.between(0.5, 2.0), chance.between(0.5, 2.0)),
        middle = chance.vector(2.0);
    std::vector<Vector3d> points;
    for (int k = 0; k < 6; ++k)
      points.push_back(middle + R * ((k < 3 ? 1.0 : -1.0) * scale[k % 3] * Vector3d::Unit(k % 3)));
    Cells cells;
    for (const Index x : {0, 3})
      for (const Index y : {1, 4})
        for (const Index z : {2, 5}) {
          cells.push_back({x, y, z});
          if (chance.flip(0.5)) std::swap(cells.back()[0], cells.back()[1]);
        }
    const Mesh mesh = shells(points, cells);
    const ShellSides sides = shells_of_one_side(mesh, mesh.shells, chance.direction());
    for (Eigen::Index row = 0; row < 8; ++row) {
      const auto at = [&](int k) -> Vector3d { return mesh.points.row(mesh.shells[0].nodes(row, k)); };
      const Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0));
      const bool inwards = normal.dot((at(0) + at(1) + at(2)) / 3.0 - middle) < 0.0;
      EXPECT_EQ(sides.turned[0][static_cast<std::size_t>(row)] != 0, inwards) << row;
    }
  }
  std::vector<Vector3d> strip;
  Cells cells;
  constexpr int n = 12;
  for (int k = 0; k < n; ++k) {
    const double a = 2.0 * M_PI * k / n;
    const Vector3d out(std::cos(a), std::sin(a), 0.0),
        across = std::cos(a / 2) * out + std::sin(a / 2) * Vector3d::UnitZ();
    strip.push_back(out - 0.2 * across);
    strip.push_back(out + 0.2 * across);
  }
  for (Index k = 0; k + 1 < n; ++k) cells.push_back({2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2});
  cells.push_back({2 * n - 2, 2 * n - 1, 0, 1});  // half a turn further
  const Mesh mesh = shells(strip, cells);
  EXPECT_THAT(mbs::test::refusal_of([&] { pushed(mesh, Vector3d::UnitZ()); }), HasSubstr("Moebius"));
}

}  // namespace
}  // namespace flexura::mesh
