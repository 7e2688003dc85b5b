// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/shell_bending.hpp"

#include <Eigen/Geometry>

namespace flexura::reduce::shell {

std::vector<Bending::Side> Bending::sides_of(const Corners& x) {
  std::vector<Side> sides;
  const int n = static_cast<int>(x.rows());
  for (int k = 0; k < n; ++k) {
    const Vector2d d = (x.row((k + 1) % n) - x.row(k)).transpose();
    sides.push_back({k, (k + 1) % n, d.norm(), d.normalized()});
  }
  return sides;
}

Bending::Bending(const Corners& x, const Matrix3d& D, const Matrix2d& S)
    : x_(x), n_(x.rows()), sides_(sides_of(x)), Db_(n_, 3 * n_), phi_(n_) {
  Db_.setZero();
  for (Index k = 0; k < n_; ++k) {
    const Side& side = sides_[static_cast<std::size_t>(k)];
    const double c = side.s(0), s = side.s(1);
    const Vector3d stretch(c * c, s * s, 2 * c * s);
    const double bending = stretch.dot(D * stretch), shear = side.s.dot(S * side.s);
    phi_(k) = 12.0 * bending / (side.length * side.length * shear);
    const double factor = -1.5 / (side.length * (1.0 + phi_(k)));
    Db_(k, 3 * side.i) -= factor;
    Db_(k, 3 * side.j) += factor;
    for (const int corner : {side.i, side.j}) {  // s . beta = s_1 theta_2 - s_2 theta_1
      Db_(k, 3 * corner + 1) -= factor * 0.5 * side.length * s;
      Db_(k, 3 * corner + 2) += factor * 0.5 * side.length * c;
    }
  }
}

MatrixXd Bending::curvature(const Functions& f, const Matrix2d& J_inverse) const {
  const MatrixXd dN = f.dN * J_inverse, dP = f.dP * J_inverse;
  MatrixXd B = MatrixXd::Zero(3, 3 * n_);
  for (Index i = 0; i < n_; ++i) {
    B(0, 3 * i + 2) += dN(i, 0);
    B(1, 3 * i + 1) -= dN(i, 1);
    B(2, 3 * i + 2) += dN(i, 1);
    B(2, 3 * i + 1) -= dN(i, 0);
  }
  for (Index k = 0; k < n_; ++k) {
    const Vector2d& s = sides_[static_cast<std::size_t>(k)].s;
    const Vector3d of_side(dP(k, 0) * s(0), dP(k, 1) * s(1), dP(k, 1) * s(0) + dP(k, 0) * s(1));
    B += of_side * Db_.row(k);
  }
  return B;
}

MatrixXd Bending::shear(const Functions& f, const Matrix2d& J_inverse, double r, double s) const {
  MatrixXd covariant = MatrixXd::Zero(2, 3 * n_);
  for (Index k = 0; k < n_; ++k) {
    const Side& side = sides_[static_cast<std::size_t>(k)];
    const Eigen::RowVectorXd along = -2.0 / 3.0 * phi_(k) * side.length * Db_.row(k);
    Vector2d weight;
    if (n_ == 3)
      weight = (f.N(side.i) * f.dN.row(side.j) - f.N(side.j) * f.dN.row(side.i)).transpose();
    else  // the covariant component is half the side's length times the strain along it
      weight = k == 0   ? Vector2d(0.25 * (1 - s), 0)
               : k == 1 ? Vector2d(0, 0.25 * (1 + r))
               : k == 2 ? Vector2d(-0.25 * (1 + s), 0)
                        : Vector2d(0, -0.25 * (1 - r));
    covariant += weight * along;
  }
  return J_inverse.transpose() * covariant;
}

}  // namespace flexura::reduce::shell
