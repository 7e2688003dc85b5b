// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/cells/record.hpp"

namespace flexura::mesh {
namespace {

std::vector<CellType> all_types() {
  std::vector<CellType> types;
  for (const CellRecord& record : cell_records()) types.push_back(record.type);
  return types;
}

bool is_pyramid(CellType type) {
  return shape_of(type).corners == 5;
}

/// Each function is one at its own node and zero at the others.  At a pyramid's apex the rational functions
/// are taken 1e-9 below it, where they differ from the limit by as much.
TEST(ShapeFunctions, AreOneAtTheirOwnNode) {
  for (const CellType type : all_types()) {
    const auto& x = reference_nodes(type);
    ASSERT_EQ(x.rows(), nodes_per_cell(type));
    for (Eigen::Index k = 0; k < x.rows(); ++k) {
      const bool apex = is_pyramid(type) && k == 4;
      const Eigen::VectorXd N = evaluate_shape(type, x.row(k).transpose()).N;
      const Eigen::VectorXd expected = Eigen::VectorXd::Unit(N.size(), k);
      EXPECT_LT((N - expected).cwiseAbs().maxCoeff(), apex ? 1e-8 : 1e-14) << name_of(type) << " node " << k;
    }
  }
}

/// Constant and linear fields are interpolated exactly with their gradients: sum N = 1, sum x_k N_k = x,
/// sum x_k dN_k = I.  Round-off of a few dozen terms of size one: 1e-13.
TEST(ShapeFunctions, ReproduceLinearFields) {
  for (const CellType type : all_types()) {
    const auto& x = reference_nodes(type);
    const int d = dimension_of(type);
    const Quadrature& rule = volume_quadrature(type);
    for (Eigen::Index q = 0; q < rule.points.rows(); ++q) {
      const ShapeValues shape = evaluate_shape(type, rule.points.row(q).transpose());
      EXPECT_NEAR(shape.N.sum(), 1, 1e-13) << name_of(type);
      const Eigen::Vector3d at = x.transpose() * shape.N;
      const Eigen::Matrix3d gradient = x.transpose() * shape.dN;
      Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
      expected.topLeftCorner(d, d).setIdentity();
      EXPECT_LT((at - rule.points.row(q).transpose()).norm(), 1e-13) << name_of(type);
      EXPECT_LT((gradient - expected).norm(), 1e-12) << name_of(type);
    }
  }
}

/// Quadratic solids other than the rational pyramid hold all quadratic polynomials.
TEST(ShapeFunctions, ReproduceQuadraticFields) {
  const auto field = [](const Eigen::Vector3d& p) {
    return 1 + p.x() - 2 * p.y() + p.z() * p.z() + p.x() * p.y() - 3 * p.y() * p.z() + p.x() * p.x();
  };
  for (const CellType type : all_types()) {
    if (dimension_of(type) != 3 || is_pyramid(type) || record_of(type).is_linear()) continue;
    const auto& x = reference_nodes(type);
    Eigen::VectorXd nodal(x.rows());
    for (Eigen::Index k = 0; k < x.rows(); ++k) nodal[k] = field(x.row(k).transpose());
    const Quadrature& rule = volume_quadrature(type);
    for (Eigen::Index q = 0; q < rule.points.rows(); ++q) {
      const Eigen::Vector3d p = rule.points.row(q).transpose();
      EXPECT_NEAR(evaluate_shape(type, p).N.dot(nodal), field(p), 1e-13) << name_of(type);
    }
  }
}

/// Monomials x^a y^b z^c over the reference simplex: a! b! c! / (a + b + c + 3)!.
TEST(Quadrature, TetrahedronOfDegreeFive) {
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  const Quadrature& rule = volume_quadrature(CellType::tet10);
  EXPECT_GT(rule.weights.minCoeff(), 0);
  for (int a = 0; a <= 5; ++a)
    for (int b = 0; a + b <= 5; ++b)
      for (int c = 0; a + b + c <= 5; ++c) {
        double sum = 0;
        for (Eigen::Index q = 0; q < rule.weights.size(); ++q)
          sum += rule.weights[q] * std::pow(rule.points(q, 0), a) * std::pow(rule.points(q, 1), b) *
                 std::pow(rule.points(q, 2), c);
        const double exact = factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
        EXPECT_NEAR(sum, exact, 1e-15) << a << b << c;  // weights sum to 1/6; the points carry 19 digits
      }
}

/// Both families of rules give the volumes of the reference cells; all points lie inside.
TEST(Quadrature, WeightsSumToTheReferenceVolume) {
  const auto exact = [](CellType type) {
    switch (shape_of(type).corners) {
      case 2:
        return 2.0;
      case 3:
        return 0.5;
      case 5:
        return 4.0 / 3;
      case 6:
        return 1.0;
      case 8:
        return 8.0;
      default:
        return dimension_of(type) == 3 ? 1.0 / 6 : 4.0;
    }
  };
  for (const CellType type : all_types()) {
    EXPECT_NEAR(volume_quadrature(type).weights.sum(), exact(type), 1e-14) << name_of(type);
    EXPECT_NEAR(stiffness_quadrature(type).weights.sum(), exact(type), 1e-14) << name_of(type);
  }
}

/// Divergence theorem on the reference cell: sum over flat faces of c . n A = 3 V, and sum n A = 0.  Holds
/// only if every face is listed once and seen from outside.
TEST(CellFaces, CloseTheCellAndLookOutwards) {
  for (const CellType type : all_types()) {
    if (dimension_of(type) != 3) continue;
    const auto& x = reference_nodes(type);
    Eigen::Vector3d closed = Eigen::Vector3d::Zero();
    double flux = 0;
    for (const CellFace& face : shape_of(type).faces) {
      ASSERT_EQ(static_cast<int>(face.nodes.size()), nodes_per_cell(face.type)) << name_of(type);
      const Quadrature& rule = volume_quadrature(face.type);
      for (Eigen::Index q = 0; q < rule.weights.size(); ++q) {
        const ShapeValues shape = evaluate_shape(face.type, rule.points.row(q).transpose());
        Eigen::Vector3d p = Eigen::Vector3d::Zero(), a = p, b = p;
        for (std::size_t k = 0; k < face.nodes.size(); ++k) {
          const Eigen::Vector3d node = x.row(face.nodes[k]).transpose();
          p += shape.N[static_cast<Eigen::Index>(k)] * node;
          a += shape.dN(static_cast<Eigen::Index>(k), 0) * node;
          b += shape.dN(static_cast<Eigen::Index>(k), 1) * node;
        }
        const Eigen::Vector3d dA = a.cross(b) * rule.weights[q];
        closed += dA;
        flux += p.dot(dA);
      }
    }
    EXPECT_LT(closed.norm(), 1e-14) << name_of(type);
    EXPECT_NEAR(flux, 3 * volume_quadrature(type).weights.sum(), 1e-13) << name_of(type);
  }
}

}  // namespace
}  // namespace flexura::mesh
