// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/triangle.hpp"

#include <Eigen/LU>
#include <cmath>

namespace flexura::beam {

const std::array<QuadraturePoint, 7>& triangle_quadrature() {
  static const std::array<QuadraturePoint, 7> points = [] {
    const double root = std::sqrt(15.0), a = (6 - root) / 21, b = (6 + root) / 21;
    const double w_a = (155 - root) / 2400, w_b = (155 + root) / 2400;
    return std::array<QuadraturePoint, 7>{{{1.0 / 3, 1.0 / 3, 9.0 / 80},
                                           {a, a, w_a},
                                           {1 - 2 * a, a, w_a},
                                           {a, 1 - 2 * a, w_a},
                                           {b, b, w_b},
                                           {1 - 2 * b, b, w_b},
                                           {b, 1 - 2 * b, w_b}}};
  }();
  return points;
}

Place place_in(const SectionMesh& mesh, int cell, double r, double s) {
  const double t = 1 - r - s;
  Place p;
  p.N << t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t;
  Eigen::Matrix<double, 6, 2> local;
  local << 1 - 4 * t, 1 - 4 * t, 4 * r - 1, 0, 0, 4 * s - 1, 4 * (t - r), -4 * r, 4 * s, 4 * r, -4 * s,
      4 * (t - s);
  Eigen::Matrix<double, 6, 2> X;
  for (int k = 0; k < 6; ++k) X.row(k) = mesh.points.row(mesh.triangles(cell, k));
  const Eigen::Matrix2d J = local.transpose() * X;
  p.det = J.determinant();
  p.dN = local * J.inverse().transpose();
  p.y = p.N.dot(X.col(0));
  p.z = p.N.dot(X.col(1));
  return p;
}

Operators operators_at(const Place& p) {
  Operators o;
  for (int k = 0; k < 6; ++k) {
    const double dy = p.dN(k, 0), dz = p.dN(k, 1), n = p.N(k);
    const int c = 3 * k;
    o.B(1, c + 1) = dy;  // yy
    o.B(2, c + 2) = dz;  // zz
    o.B(3, c + 1) = dz;  // yz
    o.B(3, c + 2) = dy;
    o.B(4, c) = dz;  // xz
    o.B(5, c) = dy;  // xy
    o.S(0, c) = n;
    o.S(4, c + 2) = n;
    o.S(5, c + 1) = n;
  }
  o.Phi(0, N) = 1;
  o.Phi(0, M_y) = p.z;
  o.Phi(0, M_z) = -p.y;
  o.Phi(4, V_z) = 1;
  o.Phi(4, T) = p.y;
  o.Phi(5, V_y) = 1;
  o.Phi(5, T) = -p.z;
  return o;
}

}  // namespace flexura::beam
