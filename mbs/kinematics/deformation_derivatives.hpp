// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "mbs/base/math/spatial.hpp"

namespace flexura::mbs {

/// What a force that follows a body's deformation and its rate says of its derivatives beside `Derivatives`: taken at once,
/// since there are as many numbers as coordinates of the body (Derivatives::deformations).
class DeformationDerivatives {
 public:
  using Rows = Eigen::Ref<const Eigen::MatrixXd>;
  virtual ~DeformationDerivatives() = default;

  /// Of the wrench named last: by the rate of the modal coordinate i of a body.
  virtual void by_deformation_rate(int body, int i, const Vector6d& d) = 0;
  /// Of all forces on the m modal coordinates of a body, as Loads::apply_modal puts them: by the relative motion of two
  /// markers (m x 12, as Derivatives::by_relative), by the modal coordinates and by their rates of `by` (columns).
  virtual void modal_forces(int body, int marker_F, int marker_M, const Rows& by_relative) = 0;
  virtual void modal_forces_by(int body, int by, const Rows& by_s, const Rows& by_s_dot) = 0;
};

}  // namespace flexura::mbs
