// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "mbs/base/math/spatial.hpp"

namespace flexura::mbs {

/// "xyz", "zxz", ...: axes of three turns, each turned by those before it; where all differ the angles are Cardan's
/// (Tait-Bryan), where the third is the first Euler's.
inline std::vector<std::string> rotation_sequences() {
  return {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"};
}

/// Its axes, 0 to 2.
inline std::array<int, 3> axes_of_sequence(const std::string& sequence) {
  std::array<int, 3> axes{};
  for (std::size_t i = 0; i < 3; ++i) axes[i] = sequence[i] - 'x';
  return axes;
}

/// R_i(q_1) R_j(q_2) R_k(q_3) of the axes i, j, k and the angles q [rad].
inline Matrix3d rotation_by_angles(const std::array<int, 3>& axes, const Vector3d& q) {
  Matrix3d R = Matrix3d::Identity();
  for (std::size_t i = 0; i < 3; ++i)
    R = R * Eigen::AngleAxisd(q(static_cast<Eigen::Index>(i)), Vector3d::Unit(axes[i])).toRotationMatrix();
  return R;
}

}  // namespace flexura::mbs
