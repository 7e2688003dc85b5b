// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/mesh_sizes.hpp"

#include <gtest/gtest.h>

#include "mesh/model/geometry.hpp"

namespace flexura::reduce {
namespace {

/// An L of three unit cubes (0, 1, 2 along x at z = 0; the third on top of the first), bricks of order 1: one edge of 270
/// degrees, x = 1, z = 1.
Part angle() {
  Part part;
  const std::vector<std::array<int, 3>> corners = {
      {0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}, {0, 0, 1}, {1, 0, 1},
      {2, 0, 1}, {0, 1, 1}, {1, 1, 1}, {2, 1, 1}, {0, 0, 2}, {1, 0, 2}, {0, 1, 2}, {1, 1, 2}};
  part.mesh.points.resize(static_cast<Eigen::Index>(corners.size()), 3);
  for (std::size_t k = 0; k < corners.size(); ++k)
    for (int d = 0; d < 3; ++d) part.mesh.points(static_cast<Eigen::Index>(k), d) = corners[k][d];
  mesh::CellBlock block;
  block.type = mesh::CellType::hex8;
  block.nodes.resize(3, 8);
  block.nodes << 0, 1, 4, 3, 6, 7, 10, 9,  //
      1, 2, 5, 4, 7, 8, 11, 10,            //
      6, 7, 10, 9, 12, 13, 15, 14;
  part.mesh.solids.push_back(block);
  mesh::extract_boundary(part.mesh);
  return part;
}

TEST(MeshSizes, ReentrantEdgesAndRimsOfWhatIsHeldAreSharp) {
  Part part = angle();
  const std::vector<char> edge = nodes_at_sharp_edges(part);
  for (std::size_t node = 0; node < edge.size(); ++node)
    EXPECT_EQ(edge[node], node == 7 || node == 10) << node;
  InterfaceSpec held;
  held.set.nodes = {2, 5, 8, 11};  // the face x = 2
  part.interfaces.push_back(held);
  const std::vector<char> rim = nodes_at_sharp_edges(part);
  for (std::size_t node = 0; node < rim.size(); ++node)
    EXPECT_EQ(rim[node], node == 7 || node == 10 || node == 2 || node == 5 || node == 8 || node == 11)
        << node;
}

/// The cells beside the edge leave e f^1.1, the other e f^2 (order 1), one part in cells to f^-1 and f^-3: with errors of 1
/// each and the sum brought to 0.3, the condition of the fewest cells is solved here by bisection over the one unknown that
/// the sum leaves free.
TEST(MeshSizes, AreThoseOfTheFewestCells) {
  const Part part = angle();
  std::vector<char> sharp(16, 0);
  sharp[12] = 1;  // of the third cell only
  const Eigen::VectorXd f = cell_factors(part.mesh, Eigen::Vector3d(0.3, 0.2, 0.5), sharp, 0.3);
  const auto left = [](double smooth_a, double smooth_b, double edge) {
    return 0.3 * smooth_a * smooth_a + 0.2 * smooth_b * smooth_b + 0.5 * std::pow(edge, 1.1);
  };
  EXPECT_NEAR(left(f(0), f(1), f(2)), 0.3, 1e-6);
  const auto cells = [](double a, double b, double edge) {
    return std::pow(a, -3.0) + std::pow(b, -3.0) + 1.0 / edge;
  };
  // No other factors with that sum need fewer: neighbours along the two directions in which the sum stays.
  for (const double step : {-1e-3, 1e-3}) {
    const auto edge_for = [&](double a, double b) {
      return std::pow((0.3 - 0.3 * a * a - 0.2 * b * b) / 0.5, 1.0 / 1.1);
    };
    const double best = cells(f(0), f(1), edge_for(f(0), f(1)));
    EXPECT_GT(cells(f(0) + step, f(1), edge_for(f(0) + step, f(1))), best);
    EXPECT_GT(cells(f(0), f(1) + step, edge_for(f(0), f(1) + step)), best);
  }
}

/// Of two motions each has what it may have, where the cells that matter are each one's own; what is in the shadow of a worse
/// motion asks for nothing.
TEST(MeshSizes, EachMotionHasASumOfItsOwn) {
  const Part part = angle();
  const std::vector<char> sharp(16, 0);
  Eigen::MatrixXd share = Eigen::MatrixXd::Zero(3, 2);
  share(0, 0) = 0.5;
  share(1, 1) = 0.4;
  const Eigen::VectorXd f = cell_factors(part.mesh, share, sharp, 0.1);
  EXPECT_NEAR(0.5 * f(0) * f(0), 0.1, 1e-3 * 0.1);  // linear cells: e f^2
  EXPECT_NEAR(0.4 * f(1) * f(1), 0.1, 0.05 * 0.1);  // as near as the multipliers come
  EXPECT_EQ(f(2), 1.5);
  Eigen::MatrixXd shadow(3, 2);
  shadow << 0.3, 0.03, 0.2, 0.01, 0.1, 0.02;
  const Eigen::VectorXd both = cell_factors(part.mesh, shadow, sharp, 0.1),
                        alone = cell_factors(part.mesh, shadow.leftCols(1), sharp, 0.1);
  EXPECT_LT((both - alone).norm(), 1e-6 * alone.norm());
}

/// Sizes at the edge are a quarter of the cells', away from it they grow by half of the way; between points that differ lie
/// others.
TEST(MeshSizes, GrowFromTheEdge) {
  const Part part = angle();
  const std::vector<char> sharp = nodes_at_sharp_edges(part);
  const std::vector<double> points = size_points(part.mesh, Eigen::Vector3d::Constant(0.25), sharp);
  ASSERT_EQ(points.size() % 4, 0u);
  EXPECT_GT(points.size() / 4, 16u);
  for (std::size_t k = 0; k < points.size(); k += 4) {
    const double distance = std::hypot(points[k] - 1.0, points[k + 2] - 1.0);
    // Along the edges of the cells.
    EXPECT_LE(points[k + 3],
              0.25 + 0.5 * (std::abs(points[k] - 1.0) + std::abs(points[k + 2] - 1.0)) + 1e-12);
    EXPECT_GE(points[k + 3], 0.25 - 1e-12);
    if (distance < 1e-9) {
      EXPECT_NEAR(points[k + 3], 0.25, 1e-12);
    }
  }
}

}  // namespace
}  // namespace flexura::reduce
