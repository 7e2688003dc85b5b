// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "beam/element/element.hpp"

namespace flexura::beam {

/// What releases do to an element with flexibility F and stretch map H (element.hpp).
struct ReleasedElement {
  /// Z (Z^T F Z)^-1 Z^T, Z a basis of the mid-span resultants that vanish in the released end components;
  /// F^-1 without releases.
  Matrix6d F_inverse = Matrix6d::Zero();
  /// Slip of the released end components for a stretch the element cannot take: E_r H_r^+, with H_r the
  /// released columns of H.  Any resultants that cancel given released end forces p_r are -slip^T p.
  Eigen::Matrix<double, 12, 6> slip = Eigen::Matrix<double, 12, 6>::Zero();
};

/// Works on resultants instead of condensing the stiffness: no digits are lost when psi is tiny.
/// Throws std::invalid_argument, naming the motion, when the releases let the element move by itself.
ReleasedElement release(const Matrix6d& F, const Matrix6x12d& H, double length, Releases releases);

}  // namespace flexura::beam
