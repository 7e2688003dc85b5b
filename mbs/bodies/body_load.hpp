// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/base/math/spatial.hpp"

namespace flexura::mbs {

/// A load case of a superelement on the body made of it: forces p spread over the body, whose components in B
/// are constant.  Their virtual work is, with the points at rho = x + Phi s,
///
///     sum p . (d_Bo + d_theta x rho + Phi d_s) = F . d_Bo + (T + P s) . d_theta + f . d_s
///     F = sum p,   T = sum x x p,   P_i = sum Phi_i x p,   f_i = sum Phi_i . p
///
/// With geometric stiffening f loses K0 s: the work through the second-order displacement (modal_body.hpp).  A preload is a
/// load case without resultant, F = T = 0.
struct BodyLoad {
  std::string name;
  Spatial wrench;           ///< (T, F), about Bo in B [N m, N]
  Eigen::VectorXd modal;    ///< f, m; empty on a rigid body
  Eigen::Matrix3Xd moment;  ///< P, 3 x m; empty where it is not known, and on a rigid body
  Eigen::MatrixXd K0 = {};  ///< m x m; empty without stiffening
  bool is_preload = false;

  /// The wrench of the deformed body, in B; s may be null.
  Spatial wrench_at(const double* s) const {
    Spatial w = wrench;
    if (s && moment.size() > 0) w.angular += moment * Eigen::Map<const Eigen::VectorXd>(s, moment.cols());
    return w;
  }
  /// What the geometric stiffness adds to f; s may be null.
  Eigen::VectorXd stiffening_at(const double* s) const {
    if (!s || K0.size() == 0) return Eigen::VectorXd();
    return -K0 * Eigen::Map<const Eigen::VectorXd>(s, K0.cols());
  }
};

}  // namespace flexura::mbs
