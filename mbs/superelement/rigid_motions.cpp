// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>

#include "mbs/superelement/checks.hpp"

/// Motions of a superelement's coordinates: of one interface node, and those of the whole body as a rigid one.
namespace flexura::superelement {

Eigen::MatrixXd interface_motion(const Superelement& se, const Interface& interface) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(6, se.n());
  for (std::size_t k = 0; k < interface.directions.size(); ++k)
    rows(static_cast<int>(interface.directions[k]), interface.first_dof + static_cast<int>(k)) = 1.0;
  for (std::size_t k = 0; k < interface.following.size(); ++k)
    rows.row(static_cast<int>(interface.following[k])) = interface.follow.row(static_cast<Eigen::Index>(k));
  for (std::size_t k = 0; k < interface.free.size(); ++k)
    rows.row(static_cast<int>(interface.free[k])) = interface.free_motion.row(static_cast<Eigen::Index>(k));
  return rows;
}

Eigen::MatrixXd rigid_motions_about(const Superelement& se, const Eigen::Vector3d& p_BoP_B) {
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(se.n(), 6);
  for (const Interface& interface : se.interfaces) {
    const Eigen::Vector3d x = interface.p_BoN_B - p_BoP_B;
    for (std::size_t i = 0; i < interface.directions.size(); ++i) {
      const int row = interface.first_dof + static_cast<int>(i);
      const int d = static_cast<int>(interface.directions[i]);
      if (d >= 3) {
        R(row, d) = 1.0;
        continue;
      }
      R(row, d) = 1.0;
      for (int c = 0; c < 3; ++c) R(row, 3 + c) = Eigen::Vector3d::Unit(c).cross(x)[d];
    }
  }
  return R;
}

Eigen::MatrixXd rigid_motions(const Superelement& se) {
  return rigid_motions_about(se, Eigen::Vector3d::Zero());
}

}  // namespace flexura::superelement
