// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/elements/shell_cell.hpp"

namespace flexura::reduce::shell {

/// Bending: dofs w, theta_1, theta_2 of each corner.  `D` is the stiffness against curvature, `S` against transverse shear.
class Bending {
 public:
  Bending(const Corners& x, const Matrix3d& D, const Matrix2d& S);

  /// Curvatures (beta_1,1; beta_2,2; beta_1,2 + beta_2,1): 3 x 3n.
  MatrixXd curvature(const Functions& f, const Matrix2d& J_inverse) const;
  /// Shear strains (gamma_13, gamma_23): 2 x 3n, from the constant ones along the sides.
  MatrixXd shear(const Functions& f, const Matrix2d& J_inverse, double r, double s) const;

 private:
  struct Side {
    int i, j;
    double length;
    Vector2d s;
  };
  static std::vector<Side> sides_of(const Corners& x);

  Corners x_;
  Index n_;
  std::vector<Side> sides_;
  MatrixXd Db_;
  Eigen::VectorXd phi_;
};

}  // namespace flexura::reduce::shell
