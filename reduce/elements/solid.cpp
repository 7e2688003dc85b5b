// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/solid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace flexura::reduce {
namespace {

using StrainMatrix = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 3 * kMaxNodes>;

void fill_strain_matrix(const NodePositions& g, StrainMatrix& B) {
  B.resize(6, 3 * g.rows());
  for (Eigen::Index a = 0; a < g.rows(); ++a) B.middleCols<3>(3 * a) = strain_operator(g.row(a));
}

}  // namespace

Eigen::Matrix<double, 6, 3> strain_operator(const Eigen::RowVector3d& g) {
  Eigen::Matrix<double, 6, 3> B;
  B << g(0), 0, 0,    //
      0, g(1), 0,     //
      0, 0, g(2),     //
      g(1), g(0), 0,  //
      0, g(2), g(1),  //
      g(2), 0, g(0);
  return B;
}

double spatial_gradients(const TabulatedRule::Point& point, const NodePositions& x,
                         NodePositions& gradients) {
  const Eigen::Matrix3d J = point.dN.transpose() * x;  // row i: dx/dxi_i
  gradients.noalias() = point.dN * J.inverse().transpose();
  return J.determinant();
}

double element_stiffness(const Element& element, const NodePositions& x, const Matrix6& D,
                         Eigen::MatrixXd& K_e) {
  const int n = element.n_nodes;
  const bool bubbles = element.enhancement == Enhancement::bubbles;
  NodePositions gradients;
  StrainMatrix B, DB;
  Eigen::Matrix3d J_0;  // at the centre
  Eigen::MatrixXd K_au;
  Eigen::Matrix<double, 9, 9> K_aa = Eigen::Matrix<double, 9, 9>::Zero();
  if (bubbles) {
    J_0 = element.centre.points[0].dN.transpose() * x;
    K_au.setZero(9, 3 * n);
  }
  double smallest = std::numeric_limits<double>::infinity();
  K_e.setZero(3 * n, 3 * n);
  for (const TabulatedRule::Point& point : element.stiffness.points) {
    const double det = spatial_gradients(point, x, gradients);
    if (!(det > 0.0)) return det;
    smallest = std::min(smallest, det);
    fill_strain_matrix(gradients, B);
    DB.noalias() = (point.weight * det) * D * B;
    K_e.noalias() += B.transpose() * DB;
    if (bubbles) {
      const Eigen::Matrix3d slopes = (-2.0 * point.xi).asDiagonal();  // row k: dM_k/dxi
      StrainMatrix B_a, DB_a;
      fill_strain_matrix((J_0.determinant() / det) * slopes * J_0.inverse().transpose(), B_a);
      DB_a.noalias() = (point.weight * det) * D * B_a;
      K_au.noalias() += B_a.transpose() * DB;
      K_aa.noalias() += B_a.transpose() * DB_a;
    }
  }
  if (bubbles) {
    K_e.noalias() -= K_au.transpose() * K_aa.llt().solve(K_au);
    K_e = (0.5 * (K_e + K_e.transpose())).eval();
  }
  return smallest;
}

double element_mass(const Element& element, const NodePositions& x, double density, MassKind kind,
                    Eigen::MatrixXd& m_e) {
  const int n = element.n_nodes;
  double smallest = std::numeric_limits<double>::infinity();
  m_e.setZero(n, n);
  const TabulatedRule& rule = kind == MassKind::reduced ? element.stiffness : element.mass;
  for (const TabulatedRule::Point& point : rule.points) {
    const Eigen::Matrix3d J = point.dN.transpose() * x;
    const double det = J.determinant();
    if (!(det > 0.0)) return det;
    smallest = std::min(smallest, det);
    m_e.noalias() += (density * point.weight * det) * point.N * point.N.transpose();
  }
  if (kind == MassKind::lumped) {
    const double total = m_e.sum();
    Eigen::VectorXd diagonal = element.lumping == Lumping::row_sum
                                   ? Eigen::VectorXd(m_e.rowwise().sum())
                                   : Eigen::VectorXd(m_e.diagonal() * (total / m_e.trace()));
    m_e = diagonal.asDiagonal();
  }
  return smallest;
}

}  // namespace flexura::reduce
