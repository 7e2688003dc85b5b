// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/SparseCore>

#include "mbs/solver/algebra/tangents.hpp"

namespace flexura::mbs {

/// The derivatives of Tangents without their zeros: of many bodies on short chains nearly all entries are.
struct SparseTangents {
  using Sparse = Eigen::SparseMatrix<double>;
  Sparse z_p, z_v, M, G, h_p;

  explicit SparseTangents(const Tangents& d)
      : z_p(d.z_p.sparseView()),
        z_v(d.z_v.sparseView()),
        M(d.M.sparseView()),
        G(d.G.sparseView()),
        h_p(d.h_p.sparseView()) {}
};

}  // namespace flexura::mbs
