// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/elements/solid.hpp"

/// What membrane and bending of a shell element share: the flat cell in its own axes.  For shell.cpp and shell_bending.cpp.
namespace flexura::reduce::shell {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Corners = Eigen::Matrix<double, Eigen::Dynamic, 2, 0, 4, 2>;

/// Stiffness of a slice in the element's axes: plane stress (11, 22, 12) and transverse shear (13, 23), 5/6 of it.
struct PlaneStress {
  Matrix3d D;
  Matrix2d shear;
};

PlaneStress plane_stress(const Matrix6& D, const Matrix3d& R);

/// Functions of the reference cell at a point: corners N, sides P (one for each, from corner k to k + 1).
struct Functions {
  Eigen::VectorXd N, P;
  Eigen::Matrix<double, Eigen::Dynamic, 2> dN, dP, dM;  // dM: bubbles 1 - xi^2, 1 - eta^2 (quadrilaterals)
};

Functions functions_at(Index n, double r, double s);

struct Place {
  double r, s, weight;
};

/// Exact for the quadratic products of a straight cell: 2 x 2 Gauss points, or the middles of a triangle's sides.
std::vector<Place> quadrature(Index n);

/// d(x_1, x_2)/d(r, s), rows r and s; dN/dx = dN/dr J^-T with row vectors dN J_inverse, J_inverse = (J^T)^-1.
struct Jacobian {
  double det;
  Matrix2d inverse;  // columns: dr/dx_1.. such that (dN/dr, dN/ds) * inverse = (dN/dx_1, dN/dx_2)
};

Jacobian jacobian(const Functions& f, const Corners& x);

}  // namespace flexura::reduce::shell
