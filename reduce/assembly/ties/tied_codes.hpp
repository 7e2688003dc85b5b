// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>

#include "reduce/assembly/ties/tied_numbering.hpp"

// Where a nodal displacement is in the tied model, in one integer; for the .cpp files of this room and of TiedModel only.
namespace flexura::reduce {

inline constexpr int kUnused = std::numeric_limits<int>::min();  // the node belongs to no cell
inline constexpr int kSlave = kUnused + 1;    // follows a rigid tie, or others by a constraint
inline constexpr int kPending = kUnused + 2;  // not numbered yet

constexpr bool is_dof(int code) {
  return code > kPending;
}
constexpr int boundary_code(int b) {
  return -(b + 1);
}
constexpr int boundary_of(int code) {
  return -code - 1;
}

template <class Visit>
void TiedNumbering::each_dof(mesh::Index node, const Visit& visit) const {
  if (const int slave = slave_of_[node]; slave >= 0) {
    for (int k = slave_begin_[slave]; k < slave_begin_[slave + 1]; ++k) visit(slave_code_[k], slave_C_[k]);
    return;
  }
  for (int d = 0; d < 3; ++d)
    if (const int own = code(node, d); is_dof(own)) visit(own, Eigen::Vector3d(Eigen::Vector3d::Unit(d)));
}

}  // namespace flexura::reduce
