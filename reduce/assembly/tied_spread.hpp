// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/tied_codes.hpp"
#include "reduce/assembly/tied_motions.hpp"

// C and its transpose row by row; for the .cpp files of TiedMotions and TiedModel only.
namespace flexura::reduce {

template <class Read, class Rows>
void TiedMotions::spread(const Read& read, Rows& U) const {
  for (Eigen::Index d = 0; d < U.rows(); ++d)
    if (is_dof(code_[d])) read(code_[d], U.row(d));
  Eigen::Matrix<double, 1, Rows::ColsAtCompileTime> q(U.cols());
  for (int node = 0; node < n_nodes_; ++node) {
    const int slave = slave_of_[node];
    if (slave < 0) continue;
    auto u = U.template middleRows<3>(3 * static_cast<Eigen::Index>(node));
    u.setZero();
    for (int k = slave_begin_[slave]; k < slave_begin_[slave + 1]; ++k) {
      read(slave_code_[k], q);
      u.noalias() += slave_C_[k] * q;
    }
  }
}

template <class Rows, class Add>
void TiedMotions::collect(const Rows& F, const Add& add) const {
  for (Eigen::Index d = 0; d < F.rows(); ++d)
    if (is_dof(code_[d]) && slave_of_[d / 3] < 0) add(code_[d], F.row(d));
  Eigen::Matrix<double, 1, Rows::ColsAtCompileTime> share(F.cols());
  for (int node = 0; node < n_nodes_; ++node) {
    const int slave = slave_of_[node];
    if (slave < 0) continue;
    for (int k = slave_begin_[slave]; k < slave_begin_[slave + 1]; ++k) {
      share.noalias() =
          slave_C_[k].transpose() * F.template middleRows<3>(3 * static_cast<Eigen::Index>(node));
      add(slave_code_[k], share);
    }
  }
}

}  // namespace flexura::reduce
