// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>

// Where a nodal displacement is in the tied model, in one integer; for the .cpp files of TiedModel only.
namespace flexura::reduce {

inline constexpr int kUnused = std::numeric_limits<int>::min();  // the node belongs to no cell
inline constexpr int kSlave = kUnused + 1;                       // follows a rigid tie
inline constexpr int kPending = kUnused + 2;                     // not numbered yet

constexpr bool is_dof(int code) {
  return code > kPending;
}
constexpr int boundary_code(int b) {
  return -(b + 1);
}
constexpr int boundary_of(int code) {
  return -code - 1;
}

}  // namespace flexura::reduce
