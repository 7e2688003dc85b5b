// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/element/element.hpp"
#include "beam/element/quadrature.hpp"

/// A point (x, y, z) of the section at x has the position and displacement
///     X_a = sum_i zeta_i X_a,i,   u_a = sum_i zeta_i U_a,i q,   zeta = (1, y, z),
/// so every integral over the section is a combination of Z_ij = int zeta_i zeta_j dm.
namespace flexura::beam {
namespace {

using Matrix3x12d = Eigen::Matrix<double, 3, 12>;

// U_a of each axis a of B: rows U_a,i.
std::array<Matrix3x12d, 3> displacement_fields(const Eigen::Matrix3d& R, const Matrix6x12d& d) {
  std::array<Matrix3x12d, 3> local, U;  // for each element axis a: rows U_a,i
  local[0] << d.row(0), -d.row(5), d.row(4);
  local[1] << d.row(1), Eigen::RowVectorXd::Zero(12), -d.row(3);
  local[2] << d.row(2), d.row(3), Eigen::RowVectorXd::Zero(12);
  for (int a = 0; a < 3; ++a) U[a] = R(a, 0) * local[0] + R(a, 1) * local[1] + R(a, 2) * local[2];
  return U;
}

Eigen::Matrix3d section_products(const SectionInertia& s, double weight) {
  Eigen::Matrix3d Z;
  Z << s.m, s.m_y, s.m_z, s.m_y, s.m_yy, s.m_yz, s.m_z, s.m_yz, s.m_zz;
  return weight * Z;
}

// Columns: position of the axis point, then of unit y and z in the section; rows: axes of B.
Eigen::Matrix3d position_field(const Placement& placement, double x) {
  Eigen::Matrix3d X = placement.R_BE;
  X.col(0) = placement.p_Bo1_B + x * placement.R_BE.col(0);
  return X;
}

// Rows a: W_i,a in B, i a displacement along (0 to 2) or a rotation about (3 to 5) an element axis, at a section `ahead`
// of the one that it turns about.
Eigen::Matrix3d rigid_field(const Eigen::Matrix3d& R, int i, double ahead) {
  Eigen::Matrix3d local = Eigen::Matrix3d::Zero();
  if (i < 3)
    local(i, 0) = 1.0;
  else if (i == 3)
    local << 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0;
  else if (i == 4)
    local << 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -ahead, 0.0, 0.0;
  else
    local << 0.0, -1.0, 0.0, ahead, 0.0, 0.0, 0.0, 0.0, 0.0;
  return R * local;
}

}  // namespace

InertiaBlocks Element::inertia_blocks(const Placement& placement) const {
  constexpr std::array<std::array<int, 2>, 6> pairs = {{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}}};
  InertiaBlocks blocks;
  const Eigen::Matrix3d& R = placement.R_BE;
  const Matrix12d transform = placement.transform();
  for (const Station& station : stations_) {
    const Eigen::Matrix3d Z = section_products(station.section.inertia, station.weight);
    const std::array<Matrix3x12d, 3> U = displacement_fields(R, station.shape * transform);
    std::array<Matrix3x12d, 3> ZU;
    for (int a = 0; a < 3; ++a) ZU[a] = Z * U[a];
    const Eigen::Matrix3d X = position_field(placement, station.xi + 0.5 * length_);

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

CutInertia Element::cut_inertia(const Placement& placement, double x) const {
  CutInertia out;
  for (Matrix6x12d& block : out.of_ends) block.setZero();
  const Matrix12d transform = placement.transform();
  // Shapes are cubic and the moment's arm is linear: four points are exact where the section is uniform.
  for (const auto& [point, weight] : gauss_points(uniform_ ? 4 : static_cast<int>(stations_.size()))) {
    const double at = 0.5 * x * (1.0 + point);
    const SectionInertia inertia = uniform_ ? section_.inertia : along_(at / length_).inertia;
    const Eigen::Matrix3d Z = section_products(inertia, 0.5 * x * weight);
    const std::array<Matrix3x12d, 3> U = displacement_fields(placement.R_BE, shape(at) * transform);
    const Eigen::Matrix3d X = position_field(placement, at);
    for (int i = 0; i < 6; ++i) {
      const Eigen::Matrix3d WZ = rigid_field(placement.R_BE, i, at - x) * Z;
      for (int b = 0; b < 3; ++b) {
        out.of_position(i, b) += WZ(b, 0);
        for (int a = 0; a < 3; ++a) {
          out.of_position(i, 3 + 3 * a + b) += WZ.row(b).dot(X.row(a));
          out.of_ends[3 * a + b].row(i) += WZ.row(b) * U[a];
        }
      }
    }
  }
  return out;
}

}  // namespace flexura::beam
