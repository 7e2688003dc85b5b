// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/modal_integrals.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <stdexcept>

namespace flexura::reduce {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using superelement::FlexDataBody;

InertiaIntegrals integrals_of(const FlexDataBody& body) {
  const Index m = body.S_phi.cols(), n = 6 + m;
  InertiaIntegrals I{.mass = body.mass, .S_x = body.S_x, .S_xx = body.S_xx};
  std::array<Vector3d, 6> t;
  std::array<Matrix3d, 6> A;
  for (int k = 0; k < 6; ++k) {
    t[k] = k < 3 ? Vector3d(Vector3d::Unit(k)) : Vector3d(Vector3d::Zero());
    A[k].setZero();
    if (k < 3) continue;
    const int c = k - 3, a = (c + 1) % 3, b = (c + 2) % 3;  // e_c x x: -x_b along a, x_a along b
    A[k](a, b) = -1.0, A[k](b, a) = 1.0;
    t[k] = -A[k] * body.S_x / body.mass;
  }
  I.S_phi.resize(3, n);
  I.S_xphi.resize(9, n);
  for (int k = 0; k < 6; ++k) {
    I.S_phi.col(k) = body.mass * t[k] + A[k] * body.S_x;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        I.S_xphi(3 * a + b, k) = body.S_x(a) * t[k](b) + A[k].row(b).dot(body.S_xx.row(a));
  }
  I.S_phi.rightCols(m) = body.S_phi;
  I.S_xphi.rightCols(m) = body.S_xphi;
  constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  for (std::size_t p = 0; p < 6; ++p) {
    const int a = kPairs[p][0], b = kPairs[p][1];
    MatrixXd& S = I.S_phiphi[p];
    S.resize(n, n);
    S.bottomRightCorner(m, m) = body.S_phiphi[p];
    for (int k = 0; k < 6; ++k) {
      for (int l = 0; l < 6; ++l)
        S(k, l) = body.mass * t[k](a) * t[l](b) + t[k](a) * A[l].row(b).dot(body.S_x) +
                  A[k].row(a).dot(body.S_x) * t[l](b) + A[k].row(a) * body.S_xx * A[l].row(b).transpose();
      for (Index l = 0; l < m; ++l) {
        S(k, 6 + l) = t[k](a) * body.S_phi(b, l);
        S(6 + l, k) = body.S_phi(a, l) * t[k](b);
        for (int d = 0; d < 3; ++d) {
          S(k, 6 + l) += A[k](a, d) * body.S_xphi(3 * d + b, l);
          S(6 + l, k) += A[k](b, d) * body.S_xphi(3 * d + a, l);
        }
      }
    }
  }
  return I;
}

// Of moments printed with three digits those of a flat body leave 1 % of the greatest (body_faults.cpp, where the mechanism's bodies
// have the same bound).
void check_body(const FlexDataBody& body, const std::string& file) {
  const Vector3d centre = body.S_x / body.mass;
  const Matrix3d second = body.S_xx - body.mass * centre * centre.transpose();
  const Matrix3d J = second.trace() * Matrix3d::Identity() - second;
  const Vector3d moments = Eigen::SelfAdjointEigenSolver<Matrix3d>(J, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(body.mass > 0.0) || Eigen::LLT<Matrix3d>(J).info() != Eigen::Success ||
      moments(0) + moments(1) < 0.99 * moments(2))
    throw std::invalid_argument(fmt::format(
        "{}: no body has the mass {:g} kg and the principal moments of inertia {:g}, {:g}, {:g} kg m^2 "
        "about its centre: all must be above 0 and none greater than the others together; check them and "
        "the units",
        file, body.mass, moments(0), moments(1), moments(2)));
}

}  // namespace flexura::reduce
