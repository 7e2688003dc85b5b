// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/recovery/peak_stress.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mesh/model/geometry.hpp"
#include "reduce/recovery/stress.hpp"
#include "reduce/superelement/mesh_report.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using mesh::CellType;

std::vector<mesh::Index> surface_nodes(const mesh::Mesh& mesh) {
  return nodes_where(mesh, [](const Vector3d&) { return true; }).nodes;
}

MatrixXd nodal(const mesh::Mesh& mesh, const std::function<Vector3d(const Vector3d&)>& field) {
  MatrixXd T(3 * static_cast<Eigen::Index>(mesh.n_nodes()), 1);
  for (mesh::Index node = 0; node < mesh.n_nodes(); ++node)
    T.middleRows<3>(3 * static_cast<Eigen::Index>(node)) = field(mesh.points.row(node));
  return T;
}

PeakStress judge(const Part& part, const MatrixXd& T) {
  const std::vector<mesh::Index> nodes = surface_nodes(part.mesh);
  return peak_stresses(part, T, nodal_stress_modes(part, T, nodes), nodes,
                       MatrixXd::Identity(T.cols(), T.cols()))
      .front();
}

Part free_part(mesh::Mesh mesh) {
  Part part;
  part.mesh = std::move(mesh);
  part.mesh.boundary.clear();
  mesh::extract_boundary(part.mesh);
  part.materials = {steel()};
  return part;
}

// Pure bending, u of second degree: 20-node bricks hold it, nothing is left but the float that keeps recovered stresses.
TEST(PeakStress, OfAFieldThatTheMeshHoldsIsExact) {
  const Part part = free_part(box({1.0, 0.2, 0.1}, {6, 2, 2}, CellType::hex20));
  const double nu = 0.3;
  const MatrixXd T = nodal(part.mesh, [&](const Vector3d& x) {
    return Vector3d(x(0) * x(2), -nu * x(1) * x(2), -0.5 * (x(0) * x(0) + nu * (x(2) * x(2) - x(1) * x(1))));
  });
  const PeakStress peak = judge(part, T);
  EXPECT_FALSE(peak.singular);
  EXPECT_NEAR(peak.von_mises, 2.1e11 * 0.1, 1.0);
  EXPECT_NEAR(peak.at.z(), 0.1, 1e-12);
  EXPECT_LT(peak.error, 1e-6);
}

struct Case {
  CellType type;
  int n;
};
class PeakStressOfACylinder : public ::testing::TestWithParam<Case> {};

// A quarter of a thick cylinder under internal pressure (Lame: u_r = r (1 - 2 nu) + b^2 / r for plane strain), greatest at the
// bore, by the nodal values of the exact displacement.  Never less than half, so that the verdict's margin covers it; stresses of
// 20-node bricks are worse at their nodes than the mean over cells that the file keeps: up to six times there.
TEST_P(PeakStressOfACylinder, IsThatOfLame) {
  constexpr double kBore = 1.0, kOuter = 2.0, kNu = 0.3;
  mesh::Mesh mesh =
      box({kOuter - kBore, std::numbers::pi / 2, 0.4}, {GetParam().n, 2 * GetParam().n, 1}, GetParam().type);
  deform(mesh, [](const Vector3d& x) {
    return Vector3d((kBore + x(0)) * std::cos(x(1)), (kBore + x(0)) * std::sin(x(1)), x(2));
  });
  const Part part = free_part(std::move(mesh));
  const auto shape = [](double r) { return r * (1 - 2 * kNu) + kOuter * kOuter / r; };
  const MatrixXd T = nodal(part.mesh, [&](const Vector3d& x) {
    const double r = std::hypot(x(0), x(1));
    return Vector3d(shape(r) * x(0) / r, shape(r) * x(1) / r, 0.0);
  });
  const PeakStress peak = judge(part, T);
  ASSERT_GE(peak.node, 0);
  EXPECT_FALSE(peak.singular);
  const double r = std::hypot(peak.at.x(), peak.at.y()), c = peak.at.x() / r, s = peak.at.y() / r;
  EXPECT_NEAR(r, kBore, 1e-9);
  // Strains du/dr and u/r, turned from (r, t) to (x, y).
  const double e_r = (1 - 2 * kNu) - kOuter * kOuter / (r * r), e_t = shape(r) / r;
  Eigen::Matrix<double, 6, 1> strain;
  strain << e_r * c * c + e_t * s * s, e_r * s * s + e_t * c * c, 0.0, 2 * (e_r - e_t) * s * c, 0.0, 0.0;
  const Eigen::Matrix<double, 6, 1> exact = part.materials[0].D * strain,
                                    off = nodal_stress_modes(part, T, {peak.node}).col(0) - exact;
  const auto mises = [](const Eigen::Matrix<double, 6, 1>& x) {
    const double xy = x(0) - x(1), yz = x(1) - x(2), zx = x(2) - x(0);
    return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3.0 * x.tail<3>().squaredNorm());
  };
  const double error = mises(off) / peak.von_mises;
  SCOPED_TRACE(::testing::Message() << "true " << error << ", estimate " << peak.error);
  EXPECT_GT(peak.error, error / kStressMargin);
  EXPECT_LT(peak.error, error * 6.0);
}

INSTANTIATE_TEST_SUITE_P(Cells, PeakStressOfACylinder,
                         ::testing::Values(Case{CellType::hex20, 2}, Case{CellType::hex20, 4},
                                           Case{CellType::tet10, 2}, Case{CellType::tet10, 4},
                                           Case{CellType::wedge15, 3}, Case{CellType::hex8, 4},
                                           Case{CellType::hex8, 8}, Case{CellType::tet4, 6},
                                           Case{CellType::wedge6, 6}));

// The greatest value lies along the edge of an angle, where it is unbounded: said, with its place; no number for it.
TEST(PeakStress, AtAReentrantEdgeIsUnbounded) {
  mesh::Mesh mesh = box({0.2, 0.2, 0.05}, {8, 8, 2}, CellType::hex20);
  for (mesh::CellBlock& block : mesh.solids) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row) {
      const Eigen::Vector3d low = mesh.points.row(block.nodes(row, 0));
      if (low(0) < 0.0999 || low(1) < 0.0999) kept.push_back(row);
    }
    block.nodes = block.nodes(kept, Eigen::all).eval();
  }
  mesh::drop_unused_nodes(mesh);
  const Part part = free_part(std::move(mesh));
  // The first term of Williams' series for 270 degrees, opening: u = r^0.5445 f(angle) (here: its size alone).
  const MatrixXd T = nodal(part.mesh, [](const Vector3d& x) {
    const double r = std::hypot(x(0) - 0.1, x(1) - 0.1);
    return Vector3d(std::pow(r, 0.5445), 0.0, 0.0);
  });
  const PeakStress peak = judge(part, T);
  EXPECT_TRUE(peak.singular);
  EXPECT_LT((peak.singular_at.head<2>() - Eigen::Vector2d(0.1, 0.1)).norm(), 0.026);  // a cell
  // Elsewhere it falls off from the edge: no maximum of its own.
  if (peak.node >= 0) {
    EXPECT_GT((peak.at.head<2>() - Eigen::Vector2d(0.1, 0.1)).norm(), 0.024);
  }
}

// A mean over its face leaves the stress bounded, a rigid one does not.
TEST(PeakStress, AtTheEdgeOfARigidInterfaceIsUnbounded) {
  for (const Tie tie : {Tie::rigid, Tie::average}) {
    const Part part = beam({0.4, 0.1, 0.1}, {8, 2, 2}, CellType::hex20, tie, tie);
    const MatrixXd T = nodal(part.mesh, [](const Vector3d& x) {
      return Vector3d(0.0, x(0) < 0.01 ? 0.0 : x(0) * x(0) * (1.2 - x(0)), 0.0);
    });
    EXPECT_EQ(judge(part, T).singular, tie == Tie::rigid);
  }
}

}  // namespace
}  // namespace flexura::reduce
