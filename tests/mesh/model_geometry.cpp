// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/geometry.hpp"
#include "mesh/model/hinges.hpp"

namespace flexura::mesh {
namespace {

/// One cell at the nodes of the reference cell, moved by `map`.
template <class Map>
Mesh single_cell(CellType type, Map map) {
  Mesh mesh;
  const auto& x = reference_nodes(type);
  mesh.points.resize(x.rows(), 3);
  CellBlock block;
  block.type = type;
  block.nodes.resize(1, x.rows());
  for (Index k = 0; k < x.rows(); ++k) {
    mesh.points.row(k) = map(Eigen::Vector3d(x.row(k).transpose())).transpose();
    block.nodes(0, k) = k;
  }
  mesh.solids.push_back(block);
  return mesh;
}

Mesh single_cell(CellType type) {
  return single_cell(type, [](const Eigen::Vector3d& p) { return p; });
}

/// x = r + a s^2 shears the simplex: det J = 1, so V = 1/6, and the centroid moves by a <s^2> = a/10
/// (integral of s^2 over the simplex is 2!/5! = 1/60).  Quadratic tetrahedra hold the map exactly.
TEST(Volume, CurvedTetrahedronIsExact) {
  const double a = 0.3;
  const Mesh mesh = single_cell(CellType::tet10, [&](Eigen::Vector3d p) {
    p.x() += a * p.y() * p.y();
    return p;
  });
  const Volumes v = measure_volume(mesh);
  EXPECT_NEAR(v.volume, 1.0 / 6, 1e-15);
  EXPECT_NEAR(v.centroid.x(), 0.25 + a / 10, 1e-14);
  EXPECT_NEAR(v.centroid.y(), 0.25, 1e-14);
  EXPECT_NEAR(measure_quality(mesh).min_ratio, 1, 1e-13);
}

/// Box of sides 2, 2, 2 stretched by (1, 2, 3): inertia V (b^2 + c^2) / 12.
TEST(Volume, InertiaOfABox) {
  const Mesh mesh = single_cell(CellType::hex20, [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x() + 100, 2 * p.y(), 3 * p.z());
  });
  const Volumes v = measure_volume(mesh);
  EXPECT_NEAR(v.volume, 48, 48e-15 * 10);
  EXPECT_NEAR(v.inertia(0, 0), 48 * (16 + 36) / 12., 1e-11);
  EXPECT_NEAR(v.inertia(1, 1), 48 * (4 + 36) / 12., 1e-11);
  EXPECT_NEAR(v.inertia(2, 2), 48 * (4 + 16) / 12., 1e-11);
  EXPECT_LT(std::abs(v.inertia(0, 1)) + std::abs(v.inertia(1, 2)) + std::abs(v.inertia(0, 2)), 1e-11);
}

TEST(Quality, RegularCellsScoreOne) {
  const Mesh hex = single_cell(CellType::hex8);
  EXPECT_NEAR(measure_quality(hex).min_scaled_jacobian, 1, 1e-15);
  const Mesh tet =
      single_cell(CellType::tet4, [](const Eigen::Vector3d& p) {  // columns: edges of a regular one
        return Eigen::Vector3d(p.x() + 0.5 * p.y() + 0.5 * p.z(),
                               std::sqrt(3) / 2 * p.y() + std::sqrt(3) / 6 * p.z(),
                               std::sqrt(2. / 3) * p.z());
      });
  EXPECT_NEAR(measure_quality(tet).min_scaled_jacobian, 1, 1e-14);
  const Mesh wedge = single_cell(CellType::wedge6, [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x() + 0.5 * p.y(), std::sqrt(3) / 2 * p.y(), p.z());
  });
  EXPECT_NEAR(measure_quality(wedge).min_scaled_jacobian, 1, 1e-14);
}

TEST(Quality, MirroredCellIsInverted) {
  const Mesh mesh = single_cell(CellType::tet10, [](Eigen::Vector3d p) {
    p.x() = -p.x();
    return p;
  });
  const Quality q = measure_quality(mesh);
  EXPECT_EQ(q.n_inverted, 1);
  EXPECT_LT(q.min_scaled_jacobian, 0);
}

/// A mid-edge node pulled through the opposite face turns the cell inside out; straightening returns the
/// straight simplex with its volume 1/6, and a good mesh is left alone.
TEST(Straightening, MendsATurnedCell) {
  Mesh mesh = single_cell(CellType::tet10);
  mesh.points.row(4) << 0.5, 0.8, 0.3;
  EXPECT_LE(measure_quality(mesh).min_ratio, 0);
  EXPECT_GT(straighten_poor_cells(mesh), 0);
  EXPECT_NEAR(measure_quality(mesh).min_ratio, 1, 1e-13);
  EXPECT_NEAR(measure_volume(mesh).volume, 1.0 / 6, 1e-15);
  EXPECT_EQ(straighten_poor_cells(mesh), 0);
}

/// Two tetrahedra that share a face have six outer faces; the sum of outward areas vanishes and c . n A sums
/// to 3 V.
TEST(Boundary, OfTwoTetrahedraIsClosedAndOutward) {
  Mesh mesh;
  mesh.points.resize(5, 3);
  mesh.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1;
  CellBlock block;
  block.type = CellType::tet4;
  block.nodes.resize(2, 4);
  block.nodes << 0, 1, 2, 3, 1, 2, 3, 4;
  mesh.solids.push_back(block);
  const double volume = measure_volume(mesh).volume;
  EXPECT_NEAR(volume, 1.0 / 6 + 1.0 / 3, 1e-15);
  extract_boundary(mesh);
  ASSERT_EQ(mesh.boundary.size(), 1u);
  ASSERT_EQ(mesh.boundary[0].nodes.rows(), 6);
  double flux = 0;
  for (Index k = 0; k < 6; ++k) {
    CellBlock one;
    one.type = CellType::tri3;
    one.nodes = mesh.boundary[0].nodes.row(k);
    const Surface s = measure_surface(mesh, {one});
    flux += s.area * s.centroid.dot(s.normal);
  }
  EXPECT_NEAR(flux, 3 * volume, 1e-14);
  EXPECT_LT(measure_surface(mesh, mesh.boundary).normal.norm(), 1e-15);
  EXPECT_EQ(find_pieces(mesh).count, 1);
}

TEST(Boundary, RefusesAFaceOfThreeCells) {
  Mesh mesh = single_cell(CellType::tet4);
  mesh.solids[0].nodes = mesh.solids[0].nodes.replicate(3, 1).eval();
  try {
    extract_boundary(mesh);
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("belongs to 3 solid cells"), std::string::npos) << e.what();
  }
}

TEST(Pieces, UnconnectedCellsAreCounted) {
  Mesh mesh;
  mesh.points = Eigen::Matrix<double, 9, 3>::Random();
  CellBlock block;
  block.type = CellType::tet4;
  block.nodes.resize(2, 4);
  block.nodes << 5, 1, 2, 3, 4, 0, 6, 7;
  mesh.solids.push_back(block);
  const Pieces pieces = find_pieces(mesh);
  EXPECT_EQ(pieces.count, 2);
  EXPECT_EQ(pieces.piece_of_node, (std::vector<Index>{0, 1, 1, 1, 0, 1, 0, 0, -1}));
  EXPECT_EQ(drop_unused_nodes(mesh), 1);
  EXPECT_EQ(mesh.n_nodes(), 8);
}

// Unit cubes beside the first: at a face, an edge, a corner, and round an edge by way of a third one.
TEST(Hinges, AreWhereSolidsShareAnEdgeOrANodeAlone) {
  const auto cubes = [](const std::vector<Eigen::RowVector3d>& places) {
    Mesh mesh;
    CellBlock block;
    block.type = CellType::hex8;
    block.nodes.resize(static_cast<Eigen::Index>(places.size()), 8);
    std::map<std::array<int, 3>, Index> number;
    std::vector<Eigen::RowVector3d> points;
    for (std::size_t c = 0; c < places.size(); ++c)
      for (int k = 0; k < 8; ++k) {
        const Eigen::RowVector3d x =
            places[c] + Eigen::RowVector3d((k == 1 || k == 2 || k == 5 || k == 6) ? 1 : 0,
                                           (k == 2 || k == 3 || k == 6 || k == 7) ? 1 : 0, k > 3 ? 1 : 0);
        const std::array<int, 3> key{static_cast<int>(x.x()), static_cast<int>(x.y()),
                                     static_cast<int>(x.z())};
        const auto [at, is_new] = number.emplace(key, static_cast<Index>(points.size()));
        if (is_new) points.push_back(x);
        block.nodes(static_cast<Eigen::Index>(c), k) = at->second;
      }
    mesh.points.resize(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t k = 0; k < points.size(); ++k) mesh.points.row(static_cast<Eigen::Index>(k)) = points[k];
    mesh.solids.push_back(block);
    return find_hinge(mesh);
  };
  EXPECT_FALSE(cubes({{0, 0, 0}, {1, 0, 0}}));
  const auto edge = cubes({{0, 0, 0}, {1, 1, 0}});
  ASSERT_TRUE(edge);
  EXPECT_TRUE(edge->line);
  EXPECT_EQ(edge->at.head<2>(), Eigen::Vector2d(1, 1));
  const auto corner = cubes({{0, 0, 0}, {1, 1, 1}});
  ASSERT_TRUE(corner);
  EXPECT_FALSE(corner->line);
  EXPECT_EQ(corner->at, Eigen::Vector3d(1, 1, 1));
  EXPECT_FALSE(cubes({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}}));
  EXPECT_FALSE(cubes({{0, 0, 0}, {5, 5, 5}}));  // two pieces, which others tell of
}

// A cube of two wedges on a brick: no face is the same, but what they share lies in no line.
TEST(Hinges, AreNotWhereFacesOfOtherShapesMeet) {
  Mesh mesh;
  mesh.points.resize(12, 3);
  mesh.points << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 0, 0, 2, 1, 0, 2, 1,
      1, 2, 0, 1, 2;
  CellBlock brick, wedges;
  brick.type = CellType::hex8;
  brick.nodes.resize(1, 8);
  brick.nodes << 0, 1, 2, 3, 4, 5, 6, 7;
  wedges.type = CellType::wedge6;
  wedges.nodes.resize(2, 6);
  wedges.nodes << 4, 5, 6, 8, 9, 10, 4, 6, 7, 8, 10, 11;
  mesh.solids = {brick, wedges};
  EXPECT_FALSE(find_hinge(mesh));
}

/// integral N dA over a flat tri6 of area A: corners 0, mid-edges A/3.  quad8 of area A: corners -A/12,
/// mid-edges A/3.
TEST(AreaWeights, OfFlatFacesAreTheTextbookOnes) {
  const auto weights = [](CellType type, AreaWeights kind) {
    Mesh mesh = single_cell(type);
    NodeSet set;
    for (Index k = 0; k < mesh.n_nodes(); ++k) set.nodes.push_back(k);
    set.faces = mesh.solids;
    return area_weights(mesh, set, kind);
  };
  const Eigen::VectorXd tri = weights(CellType::tri6, AreaWeights::consistent);
  const Eigen::VectorXd quad = weights(CellType::quad8, AreaWeights::consistent);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(tri[k], 0, 1e-15);
    EXPECT_NEAR(tri[3 + k], 0.5 / 3, 1e-15);
  }
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(quad[k], -4. / 12, 1e-14);
    EXPECT_NEAR(quad[4 + k], 4. / 3, 1e-14);
  }
  const Eigen::VectorXd positive = weights(CellType::quad8, AreaWeights::positive);
  EXPECT_GT(positive.minCoeff(), 0);
  EXPECT_NEAR(positive.sum(), 4, 1e-14);
}

}  // namespace
}  // namespace flexura::mesh
