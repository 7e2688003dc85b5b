// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

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

}  // namespace flexura::mbs
