// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>

#include "mbs/superelement/superelement.hpp"

/// A rigid plate in the xy plane whose underside touches.
namespace flexura::mbs::surfaces {

/// Four point masses of `mass` / 4 at (+- a / 2, +- a / 2, 0); its surface is a grid of n x n squares of the whole plate, looking
/// along -z.  One interface, "middle".  Centre of mass and surface lie in one plane: friction does not tip it.
inline superelement::Superelement plate(double a, int n, double mass) {
  superelement::Superelement se;
  se.name = "plate";
  se.n_b = 6;
  using D = superelement::Direction;
  se.interfaces.push_back({"middle",
                           "rigid",
                           Eigen::Vector3d::Zero(),
                           {D::u_x, D::u_y, D::u_z, D::theta_x, D::theta_y, D::theta_z},
                           0});
  const auto rigid = [](const Eigen::Vector3d& x) {
    Eigen::Matrix<double, 3, 6> phi;
    phi << Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero();
    for (int k = 0; k < 3; ++k) phi.col(3 + k) = Eigen::Vector3d::Unit(k).cross(x);
    return phi;
  };
  se.K_se.setZero(6, 6);
  se.M_se.setZero(6, 6);
  superelement::InertiaIntegrals& I = se.inertia;
  I.mass = mass;
  I.S_phi.setZero(3, 6);
  I.S_xphi.setZero(9, 6);
  for (Eigen::MatrixXd& S : I.S_phiphi) S.setZero(6, 6);
  const int ab[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  for (const double sx : {-0.5, 0.5})
    for (const double sy : {-0.5, 0.5}) {
      const Eigen::Vector3d x(sx * a, sy * a, 0.0);
      const double m = 0.25 * mass;
      const auto phi = rigid(x);
      se.M_se += m * phi.transpose() * phi;
      I.S_xx += m * x * x.transpose();
      I.S_phi += m * phi;
      for (int p = 0; p < 3; ++p)
        for (int q = 0; q < 3; ++q) I.S_xphi.row(3 * p + q) += m * x(p) * phi.row(q);
      for (int c = 0; c < 6; ++c)
        I.S_phiphi[static_cast<std::size_t>(c)] += m * phi.row(ab[c][0]).transpose() * phi.row(ab[c][1]);
    }
  const int k = n + 1;
  se.surface.vertices.resize(k * k, 3);
  se.shapes.resize(3 * k * k, 6);
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < k; ++j) {
      const Eigen::Vector3d x(a * (static_cast<double>(i) / n - 0.5), a * (static_cast<double>(j) / n - 0.5),
                              0.0);
      se.surface.vertices.row(i * k + j) = x.transpose();
      se.shapes.middleRows(3 * (i * k + j), 3) = rigid(x).cast<float>();
    }
  se.surface.triangles.resize(2 * n * n, 3);
  for (int i = 0, t = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int p = i * k + j, q = p + k;
      se.surface.triangles.row(t++) << p, p + 1, q;
      se.surface.triangles.row(t++) << p + 1, q + 1, q;
    }
  se.surface.triangle_interface.assign(static_cast<std::size_t>(2 * n * n), 0);
  return se;
}

}  // namespace flexura::mbs::surfaces
