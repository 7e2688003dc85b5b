// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/exact/strain_field.hpp"

#include <Eigen/Cholesky>
#include <stdexcept>

namespace flexura::beam::exact {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;

MatrixXd inverse(const MatrixXd& C, const char* what) {
  const Eigen::LLT<MatrixXd> factor(C);
  if (factor.info() != Eigen::Success)
    throw std::invalid_argument(std::string("the section's stiffness against ") + what +
                                " is not positive definite; give positive stiffnesses");
  return factor.solve(MatrixXd::Identity(C.rows(), C.cols()));
}

// Strains at x are (first + x slope) s: 6 x n.
struct Linear {
  MatrixXd first, slope;
};

Linear of_beam(const Matrix6d& C, double l) {
  const MatrixXd f = inverse(C, "stretch, shear, torsion and bending");
  MatrixXd linear(6, 4);  // N and the moments
  linear << f.col(0), f.rightCols(3);
  Linear out{MatrixXd(6, 10), MatrixXd::Zero(6, 10)};
  out.first << f, -0.5 * l * linear;
  out.slope.rightCols(4) = linear;
  return out;
}

Linear of_rod(const Matrix6d& C, double l) {
  const MatrixXd f = inverse(C.bottomRightCorner<3, 3>(), "torsion and bending");
  Linear out{MatrixXd::Zero(6, 6), MatrixXd::Zero(6, 6)};
  out.first.bottomRows(3) << f, -0.5 * l * f;
  out.slope.bottomRightCorner(3, 3) = f;
  return out;
}

Linear of_cable() {
  Linear out{MatrixXd::Zero(6, 3), MatrixXd::Zero(6, 3)};
  out.first(0, 0) = out.first(4, 1) = out.first(5, 2) = 1.0;
  return out;
}

}  // namespace

StrainField strain_field(Kind kind, const Matrix6d& C, double l) {
  if (!(l > 0.0))
    throw std::invalid_argument(
        "an element of a beam has no length; give the beam one that is greater than 0");
  if (kind == Kind::cable && !(C(0, 0) > 0.0))
    throw std::invalid_argument("the cable has no stiffness against stretch; give a positive EA");
  Linear x = kind == Kind::beam ? of_beam(C, l) : kind == Kind::rod ? of_rod(C, l) : of_cable();
  // The larger end's size is 1.
  for (Eigen::Index j = 0; j < x.first.cols(); ++j) {
    const auto size = [&](double at) {
      const Eigen::Matrix<double, 6, 1> strain = x.first.col(j) + at * x.slope.col(j);
      return std::hypot(strain.head<3>().norm(), l * strain.tail<3>().norm());
    };
    const double s = 1.0 / std::max(size(0.0), size(l));
    x.first.col(j) *= s;
    x.slope.col(j) *= s;
  }
  StrainField out;
  out.g_0 = x.first.topRows(3);
  out.g_1 = x.slope.topRows(3);
  out.k_0 = x.first.bottomRows(3);
  out.k_1 = x.slope.bottomRows(3);
  out.is_constant = x.slope.isZero(0.0);
  const MatrixXd middle = x.first + 0.5 * l * x.slope;
  out.K = l * middle.transpose() * C * middle + l * l * l / 12.0 * x.slope.transpose() * C * x.slope;
  out.K = (0.5 * (out.K + out.K.transpose())).eval();
  return out;
}

}  // namespace flexura::beam::exact
