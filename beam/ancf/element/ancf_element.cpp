// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/element/element_of.hpp"

namespace flexura::beam::ancf {

BeamSection uncoupled_section(double EA, double GA_sy, double GA_sz, double GI_t, double EI_y, double EI_z,
                              double rho_A, double rho_I_y, double rho_I_z) {
  BeamSection s;
  s.C.diagonal() << EA, GA_sy, GA_sz, GI_t, EI_y, EI_z;
  s.m = rho_A;
  s.m_zz = rho_I_y;
  s.m_yy = rho_I_z;
  return s;
}

void beam_inertia(const BeamSection& s, double l, Eigen::MatrixXd& mass, Eigen::VectorXd& weight) {
  mass = Eigen::MatrixXd::Zero(8, 8);
  weight = Eigen::VectorXd::Zero(8);
  for (const auto& q : gauss_rule(kMassPoints)) {
    const BeamRow S = axis_row(hermite(q.xi, l)), Y = y_row(1 - q.xi, q.xi), Z = z_row(1 - q.xi, q.xi);
    const double w = q.weight * l;
    mass += w * (s.m * S.transpose() * S + s.m_yy * Y.transpose() * Y + s.m_zz * Z.transpose() * Z);
    mass += w * s.m_y * (S.transpose() * Y + Y.transpose() * S);
    mass += w * s.m_z * (S.transpose() * Z + Z.transpose() * S);
    mass += w * s.m_yz * (Y.transpose() * Z + Z.transpose() * Y);
    weight += w * (s.m * S + s.m_y * Y + s.m_z * Z).transpose();
  }
}

}  // namespace flexura::beam::ancf
