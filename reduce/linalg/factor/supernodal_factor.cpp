// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/supernodal_factor.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "reduce/linalg/factor/fronts.hpp"

namespace flexura::linalg {

int SupernodalFactor::factorise(const UpperCsr& A, bool must_be_definite, const FactorStorage& storage) {
  if (A.n != n_) throw std::logic_error("factorise: the matrix is not the one that was analysed");
  if (n_ == 0) return -1;
  if (single_ != storage.single) values_ = {};
  single_ = storage.single;
  return single_ ? run<float>(A, must_be_definite, storage) : run<double>(A, must_be_definite, storage);
}

template <class Real>
int SupernodalFactor::run(const UpperCsr& A, bool must_be_definite, const FactorStorage& storage) {
  Fronts<Real> fronts(A, *this, must_be_definite);
  if (!values_.data()) {
    // Beside the fronts the matrix is held once more, permuted; afterwards the factor stands beside other
    // work.
    const double permuted = 12.0 * static_cast<double>(A.columns.size());
    const double needed = std::max(fronts.peak_bytes() + permuted, bytes() + storage.reserve);
    const bool file = storage.place == FactorStorage::Place::file ||
                      (storage.place == FactorStorage::Place::automatic && needed > available_memory());
    values_ = file ? FactorStore::in_file(n_bytes(), storage.folder) : FactorStore::in_memory(n_bytes());
  }
  signs_.assign(n_, 1.0);
  diagonal_.assign(n_, 0.0);
  const int column = fronts.run();
  return column < 0 ? -1 : order_[column];
}

SupernodalFactor::Pivot SupernodalFactor::smallest_pivot(const UpperCsr& A) const {
  Pivot smallest;
  for (int k = 0; k < n_; ++k) {
    const int row = order_[k];
    const double ratio = diagonal_[k] * diagonal_[k] / std::abs(A.values[A.row_begin[row]]);
    if (!(ratio >= smallest.ratio)) smallest = {ratio, row};
  }
  return smallest;
}

int SupernodalFactor::n_negative() const {
  return static_cast<int>(std::count_if(signs_.begin(), signs_.end(), [](double s) { return s < 0.0; }));
}

}  // namespace flexura::linalg
