// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/strain.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace flexura::reduce {

void fill_strain_matrix(const NodePositions& g, StrainMatrix& B) {
  B.resize(6, 3 * g.rows());
  for (Eigen::Index a = 0; a < g.rows(); ++a) B.middleCols<3>(3 * a) = strain_operator(g.row(a));
}

void fill_bubble_matrix(const TabulatedRule::Point& point, const Eigen::Matrix3d& J_0, double det,
                        StrainMatrix& B) {
  const Eigen::Matrix3d slopes = (-2.0 * point.xi).asDiagonal();  // row k: dM_k/dxi
  fill_strain_matrix((J_0.determinant() / det) * slopes * J_0.inverse().transpose(), B);
}

StrainField::StrainField(const Element& element, const NodePositions& x, const Matrix6& D)
    : element_(element), x_(x) {
  if (is_plain()) return;
  NodePositions g;
  StrainMatrix B, B_a;
  const bool bubbles = element.enhancement == Enhancement::bubbles;
  Eigen::Matrix<double, 9, 9> K_aa = Eigen::Matrix<double, 9, 9>::Zero();
  if (bubbles) {
    centre_ = element.centre.points[0].dN.transpose() * x;
    bubbles_.setZero(9, 3 * x.rows());
  }
  mean_.setZero(x.rows(), 3);
  for (const TabulatedRule::Point& point : element.stiffness.points) {
    const double det = spatial_gradients(point, x, g);
    if (!(det > 0.0)) {
      inverted_ = det;
      return;
    }
    const double weight = point.weight * det;
    volume_ += weight;
    mean_ += weight * g;
    if (!bubbles && element.strains != Strains::at_points) continue;
    fill_strain_matrix(g, B);
    if (element.strains == Strains::at_points) at_points_.push_back(B);
    if (!bubbles) continue;
    fill_bubble_matrix(point, centre_, det, B_a);
    const StrainMatrix DB_a = weight * D * B_a;
    bubbles_.noalias() += DB_a.transpose() * B;
    K_aa.noalias() += B_a.transpose() * DB_a;
  }
  mean_ /= volume_;
  if (bubbles) bubbles_ = -K_aa.llt().solve(bubbles_);
}

double StrainField::at(const TabulatedRule::Point& point, StrainMatrix& B) const {
  NodePositions g;
  const double det = spatial_gradients(point, x_, g);
  if (!(inverted_ > 0.0)) {
    fill_strain_matrix(g, B);
    return std::min(det, inverted_);
  }
  switch (element_.strains) {
    case Strains::whole:
      fill_strain_matrix(g, B);
      break;
    case Strains::mean_volume: {
      fill_strain_matrix(g, B);
      const Eigen::RowVectorXd more = (mean_ - g).reshaped<Eigen::RowMajor>().transpose() / 3.0;
      B.topRows<3>().rowwise() += more;
      break;
    }
    case Strains::uniform:
      fill_strain_matrix(mean_, B);
      break;
    case Strains::at_points: {  // two points along each direction
      const double c = std::abs(element_.stiffness.points[0].xi(0));
      B.setZero(6, 3 * x_.rows());
      for (std::size_t q = 0; q < at_points_.size(); ++q) {
        const Eigen::Array3d side = element_.stiffness.points[q].xi.array() / (c * c);
        B += (0.5 * (1.0 + side * point.xi.array())).prod() * at_points_[q];
      }
      break;
    }
  }
  if (element_.enhancement == Enhancement::bubbles) {
    StrainMatrix B_a;
    fill_bubble_matrix(point, centre_, det, B_a);
    B += B_a * bubbles_;
  }
  return det;
}

}  // namespace flexura::reduce
