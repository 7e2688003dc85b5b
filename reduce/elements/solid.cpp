// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/solid.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "reduce/elements/strain.hpp"

namespace flexura::reduce {
namespace {

// What holds hourglasses: the share of the shear modulus that Abaqus gives them (Analysis User's Guide, Section controls:
// 0.005 G), times integral b b dV.  Its cantilevers of 2, 4 and 8 layers (Getting Started, table of reduced integration: 1.323,
// 1.063, 1.015 of beam theory) come out with a half of it on amplitudes of one.
constexpr double kHourglass = 0.0025;

// Flanagan, Belytschko (Int. J. Numer. Meth. Eng. 17 (1981), 679): gamma_k = (h_k - b (x^T h_k)) / 8 is orthogonal to what is linear.
void add_hourglass_stiffness(const NodePositions& x, const Matrix6& D, const NodePositions& b, double V,
                             Eigen::MatrixXd& K) {
  static const Eigen::Matrix<double, 8, 4> h = [] {
    Eigen::Matrix<double, 8, 4> out;
    const auto nodes = mesh::reference_nodes(mesh::CellType::hex8);
    for (Eigen::Index a = 0; a < 8; ++a) {
      const double r = nodes(a, 0), s = nodes(a, 1), t = nodes(a, 2);
      out.row(a) << s * t, t * r, r * s, r * s * t;
    }
    return out;
  }();
  const Eigen::Matrix<double, 8, 4> gamma = (h - b * (x.transpose() * h)) / 8.0;
  const double G = (D(3, 3) + D(4, 4) + D(5, 5)) / 3.0;
  const Eigen::Matrix<double, 8, 8> k = (kHourglass * G * V * b.squaredNorm()) * gamma * gamma.transpose();
  for (Eigen::Index a = 0; a < 8; ++a)
    for (Eigen::Index c = 0; c < 8; ++c) K.block<3, 3>(3 * a, 3 * c).diagonal().array() += k(a, c);
}

}  // namespace

void fill_hourglass_stiffness(const Element& element, const NodePositions& x, const Matrix6& D,
                              Eigen::MatrixXd& K) {
  K.setZero(3 * element.n_nodes, 3 * element.n_nodes);
  if (element.strains != Strains::uniform) return;
  const StrainField field(element, x, D);
  add_hourglass_stiffness(x, D, field.mean_gradients(), field.volume(), K);
}

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
  const StrainField field(element, x, D);
  const bool at_points = element.strains == Strains::at_points;
  StrainMatrix B, DB;
  NodePositions gradients;
  double smallest = std::numeric_limits<double>::infinity();
  K_e.setZero(3 * n, 3 * n);
  for (const TabulatedRule::Point& point : element.stiffness.points) {
    const double det = at_points ? spatial_gradients(point, x, gradients) : field.at(point, B);
    if (!(det > 0.0)) return det;
    smallest = std::min(smallest, det);
    if (at_points) fill_strain_matrix(gradients, B);
    DB.noalias() = (point.weight * det) * D * B;
    K_e.noalias() += B.transpose() * DB;
  }
  if (element.strains == Strains::uniform)
    add_hourglass_stiffness(x, D, field.mean_gradients(), field.volume(), K_e);
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
