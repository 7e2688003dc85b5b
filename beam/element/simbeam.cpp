// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <array>

#include "beam/element/element.hpp"

namespace flexura::beam::simbeam {
namespace {

// Element dofs of (w1, w2, beta1, beta2), and of (v1, v2, theta_z1, theta_z2).
constexpr std::array<int, 4> kBendingZ = {2, 8, 4, 10}, kBendingY = {1, 7, 5, 11};

Eigen::Matrix4d symmetric(const Eigen::Matrix4d& upper) {
  Eigen::Matrix4d full = upper.triangularView<Eigen::Upper>();
  full += upper.triangularView<Eigen::StrictlyUpper>().transpose();
  return full;
}

void add(Matrix12d& matrix, const std::array<int, 4>& dofs, const Eigen::Matrix4d& block, double sign) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) matrix(dofs[i], dofs[j]) += ((i < 2) != (j < 2) ? sign : 1.0) * block(i, j);
}

}  // namespace

double shear_factor(double EI, double GA_s, double l) {
  return 1.0 / (1.0 + 12.0 * EI / (GA_s * l * l));
}

Eigen::Matrix4d bending_stiffness(double EI, double l, double psi) {
  const double a = 12 * psi, b = 6 * l * psi;
  Eigen::Matrix4d K;
  K << a, -a, -b, -b,                                       //
      0, a, b, b,                                           //
      0, 0, l * l * (1 + 3 * psi), l * l * (-1 + 3 * psi),  //
      0, 0, 0, l * l * (1 + 3 * psi);
  return EI / (l * l * l) * symmetric(K);
}

Eigen::Matrix4d bending_mass(double rho_A, double l, double psi) {
  const double p = psi, p2 = psi * psi;
  Eigen::Matrix4d M;
  M << 4 * (70 + 7 * p + p2), 4 * (35 - 7 * p - p2), -l * (35 + 7 * p + 2 * p2),
      l * (35 - 7 * p - 2 * p2),                                                        //
      0, 4 * (70 + 7 * p + p2), -l * (35 - 7 * p - 2 * p2), l * (35 + 7 * p + 2 * p2),  //
      0, 0, l * l * (7 + p2), -l * l * (7 - p2),                                        //
      0, 0, 0, l * l * (7 + p2);
  return rho_A * l / 840 * symmetric(M);
}

Eigen::Matrix4d rotary_mass(double rho_I, double l, double psi) {
  const double p = psi, p2 = psi * psi;
  const double a = 6 * p2 / 5, b = l * (3 * p2 / 5 - p / 2), c = 3 * p2 / 10 - p / 2;
  Eigen::Matrix4d M;
  M << a, -a, -b, -b,                                      //
      0, a, b, b,                                          //
      0, 0, l * l * (c + 1.0 / 3), l * l * (c + 1.0 / 6),  //
      0, 0, 0, l * l * (c + 1.0 / 3);
  return rho_I / l * symmetric(M);
}

Matrix12d stiffness(const Constants& c, const Material& material, double l, Theory theory) {
  const double E = material.E, G = material.G;
  const bool rigid = theory == Theory::euler_bernoulli;
  const double psi_z = rigid ? 1.0 : shear_factor(E * c.I_y, G * c.A_sz, l);
  const double psi_y = rigid ? 1.0 : shear_factor(E * c.I_z, G * c.A_sy, l);
  Matrix12d K = Matrix12d::Zero();
  for (const auto& [dof, k] : {std::pair{0, E * c.A / l}, std::pair{3, G * c.I_t / l}}) {
    K(dof, dof) = K(dof + 6, dof + 6) = k;
    K(dof, dof + 6) = K(dof + 6, dof) = -k;
  }
  add(K, kBendingZ, bending_stiffness(E * c.I_y, l, psi_z), 1.0);
  add(K, kBendingY, bending_stiffness(E * c.I_z, l, psi_y), -1.0);
  return K;
}

Matrix12d mass(const Constants& c, const Material& material, double l, Theory theory, bool rotary_inertia) {
  const double E = material.E, G = material.G, rho = material.rho;
  const bool rigid = theory == Theory::euler_bernoulli;
  const double psi_z = rigid ? 1.0 : shear_factor(E * c.I_y, G * c.A_sz, l);
  const double psi_y = rigid ? 1.0 : shear_factor(E * c.I_z, G * c.A_sy, l);
  Matrix12d M = Matrix12d::Zero();
  for (const auto& [dof, m] : {std::pair{0, rho * c.A * l}, std::pair{3, rho * (c.I_y + c.I_z) * l}}) {
    M(dof, dof) = M(dof + 6, dof + 6) = m / 3;
    M(dof, dof + 6) = M(dof + 6, dof) = m / 6;
  }
  add(M, kBendingZ, bending_mass(rho * c.A, l, psi_z), 1.0);
  add(M, kBendingY, bending_mass(rho * c.A, l, psi_y), -1.0);
  if (rotary_inertia) {
    add(M, kBendingZ, rotary_mass(rho * c.I_y, l, psi_z), 1.0);
    add(M, kBendingY, rotary_mass(rho * c.I_z, l, psi_y), -1.0);
  }
  return M;
}

}  // namespace flexura::beam::simbeam
