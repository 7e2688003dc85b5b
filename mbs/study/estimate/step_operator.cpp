// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/step_operator.hpp"

#include <algorithm>

#include "mbs/base/math/simd.hpp"

namespace flexura::study {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

using Row = Lanes<4>::Row;
constexpr Index kLanes = 4;
constexpr int kRows = 3, kColumns = 4;  // so many sums at once as there are registers for

// sums = W x for R rows of lanes and C columns; W has n columns, `padded` apart, x columns `n` apart.
template <int R, int C>
FLEXURA_INLINE void add_products(const double* W, Index padded, const double* x, Index n, double* sums) {
  Row sum[R][C];
  for (int c = 0; c < C; ++c)
    for (int r = 0; r < R; ++r) sum[r][c] = *reinterpret_cast<const Row*>(sums + c * padded + r * kLanes);
  for (Index j = 0; j < n; ++j) {
    const double* const w = W + j * padded;
    for (int c = 0; c < C; ++c) {
      const double f = x[c * n + j];
      for (int r = 0; r < R; ++r) sum[r][c] += *reinterpret_cast<const Row*>(w + r * kLanes) * f;
    }
  }
  for (int c = 0; c < C; ++c)
    for (int r = 0; r < R; ++r) *reinterpret_cast<Row*>(sums + c * padded + r * kLanes) = sum[r][c];
}

template <int C>
FLEXURA_INLINE void add_columns(const double* W, Index padded, const double* x, Index n, double* sums) {
  Index at = 0;
  for (; at + kRows * kLanes <= padded; at += kRows * kLanes)
    add_products<kRows, C>(W + at, padded, x, n, sums + at);
  for (; at < padded; at += kLanes) add_products<1, C>(W + at, padded, x, n, sums + at);
}

}  // namespace

void StepOperator::set(const std::array<const MatrixXd*, 3>& W) {
  n_ = W[0]->rows();
  padded_ = (n_ + kLanes - 1) / kLanes * kLanes;
  W_.assign(static_cast<std::size_t>(3 * n_ * padded_), 0.0);
  double* to = W_.data();
  for (const MatrixXd* part : W)
    for (Index j = 0; j < n_; ++j, to += padded_) std::copy_n(part->col(j).data(), n_, to);
}

void StepOperator::apply(const MatrixXd& load, const MatrixXd& rate, const MatrixXd& position,
                         MatrixXd& next) const {
  const Index columns = load.cols(), n = n_, padded = padded_;
  sums_.assign(static_cast<std::size_t>(padded * columns), 0.0);
  const std::array<const double*, 3> parts = {load.data(), rate.data(), position.data()};
  const double* const W = W_.data();
  double* const sums = sums_.data();
  on_this_machine([=]() __attribute__((always_inline)) {
    for (Index k = 0; k < 3; ++k) {
      const double *const w = W + k * n * padded, *const x = parts[static_cast<std::size_t>(k)];
      Index c = 0;
      for (; c + kColumns <= columns; c += kColumns)
        add_columns<kColumns>(w, padded, x + c * n, n, sums + c * padded);
      for (; c < columns; ++c) add_columns<1>(w, padded, x + c * n, n, sums + c * padded);
    }
  });
  next.resize(n, columns);
  for (Index c = 0; c < columns; ++c) std::copy_n(sums + c * padded, n, next.col(c).data());
}

}  // namespace flexura::study
