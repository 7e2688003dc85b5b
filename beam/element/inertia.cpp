// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/element/element.hpp"

/// A point (x, y, z) of the section at x has the position and displacement
///     X_a = sum_i zeta_i X_a,i,   u_a = sum_i zeta_i U_a,i q,   zeta = (1, y, z),
/// so every integral over the section is a combination of Z_ij = int zeta_i zeta_j dm.
namespace flexura::beam {

InertiaBlocks Element::inertia_blocks(const Placement& placement) const {
  constexpr std::array<std::array<int, 2>, 6> pairs = {{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}}};
  using Matrix3x12d = Eigen::Matrix<double, 3, 12>;
  InertiaBlocks blocks;
  const Eigen::Matrix3d& R = placement.R_BE;
  const Matrix12d transform = placement.transform();
  for (const Station& station : stations_) {
    const SectionInertia& s = station.section.inertia;
    Eigen::Matrix3d Z;
    Z << s.m, s.m_y, s.m_z, s.m_y, s.m_yy, s.m_yz, s.m_z, s.m_yz, s.m_zz;
    Z *= station.weight;

    const Matrix6x12d d = station.shape * transform;
    std::array<Matrix3x12d, 3> local;  // for each element axis a: rows U_a,i
    local[0] << d.row(0), -d.row(5), d.row(4);
    local[1] << d.row(1), Eigen::RowVectorXd::Zero(12), -d.row(3);
    local[2] << d.row(2), d.row(3), Eigen::RowVectorXd::Zero(12);
    std::array<Matrix3x12d, 3> U, ZU;
    for (int a = 0; a < 3; ++a) {
      U[a] = R(a, 0) * local[0] + R(a, 1) * local[1] + R(a, 2) * local[2];
      ZU[a] = Z * U[a];
    }
    // Columns: position of the axis point, then of unit y and z in the section; rows: axes of B.
    Eigen::Matrix3d X;
    X.col(0) = placement.p_Bo1_B + (station.xi + 0.5 * length_) * R.col(0);
    X.col(1) = R.col(1);
    X.col(2) = R.col(2);

    blocks.mass += Z(0, 0);
    blocks.S_x += X * Z.col(0);
    blocks.S_xx += X * Z * X.transpose();
    for (int a = 0; a < 3; ++a) {
      blocks.S_phi.row(a) += ZU[a].row(0);
      for (int b = 0; b < 3; ++b) blocks.S_xphi.row(3 * a + b) += X.row(a) * ZU[b];
    }
    for (int k = 0; k < 6; ++k) blocks.S_phiphi[k] += U[pairs[k][0]].transpose() * ZU[pairs[k][1]];
  }
  return blocks;
}

}  // namespace flexura::beam
