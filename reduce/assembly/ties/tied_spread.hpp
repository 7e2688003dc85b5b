// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/ties/tied_codes.hpp"

// C of tied_model.hpp and its transpose row by row; for .cpp files only.
namespace flexura::reduce {

/// U = C u by rows: read(code, row) sets a row (of all columns) to the dof with this code.
template <class Read, class Rows>
void spread(const TiedNumbering& numbering, const Read& read, Rows& U) {
  const std::vector<int>& codes = numbering.codes();
  for (Eigen::Index d = 0; d < U.rows(); ++d)
    if (is_dof(codes[d])) read(codes[d], U.row(d));
  Eigen::Matrix<double, 1, Rows::ColsAtCompileTime> q(U.cols());
  for (int node = 0; node < numbering.n_nodes(); ++node) {
    if (!numbering.follows(node)) continue;
    auto u = U.template middleRows<3>(3 * static_cast<Eigen::Index>(node));
    u.setZero();
    const TiedNumbering::Followed followed = numbering.followed(node);
    for (std::size_t k = 0; k < followed.code.size(); ++k) {
      read(followed.code[k], q);
      u.noalias() += followed.C[k] * q;
    }
  }
}

/// C^T F by rows: add(code, row) is called for every share of a dof.
template <class Rows, class Add>
void collect(const TiedNumbering& numbering, const Rows& F, const Add& add) {
  const std::vector<int>& codes = numbering.codes();
  for (Eigen::Index d = 0; d < F.rows(); ++d)
    if (is_dof(codes[d]) && !numbering.follows(static_cast<mesh::Index>(d / 3))) add(codes[d], F.row(d));
  Eigen::Matrix<double, 1, Rows::ColsAtCompileTime> share(F.cols());
  for (int node = 0; node < numbering.n_nodes(); ++node) {
    if (!numbering.follows(node)) continue;
    const TiedNumbering::Followed followed = numbering.followed(node);
    for (std::size_t k = 0; k < followed.code.size(); ++k) {
      share.noalias() =
          followed.C[k].transpose() * F.template middleRows<3>(3 * static_cast<Eigen::Index>(node));
      add(followed.code[k], share);
    }
  }
}

}  // namespace flexura::reduce
