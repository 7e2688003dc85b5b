// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <complex>
#include <memory>
#include <vector>

/// P A = L U with partial pivoting for the small dense systems of Newton's method (n of 10 to 100), which are
/// factorised at almost every step: rows are eliminated over contiguous memory, real and imaginary parts
/// apart, entries of L that vanish (multipliers, block-diagonal kinematics) cost nothing, and pivots are
/// compared by |re| + |im|, within sqrt(2) of the modulus.  Larger systems go to Eigen::PartialPivLU,
/// whose blocks pay there.
namespace flexura::mbs {

template <class Scalar>
class SmallLu {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  SmallLu();
  ~SmallLu();

  /// A is square and finite.  A singular one gives factors whose solutions are not finite.
  void compute(const Matrix& A);
  /// x <- A^-1 x.
  void solve_in_place(Vector& x);

 private:
  static constexpr bool kComplex = !std::is_same_v<Scalar, double>;
  static constexpr int kParts = kComplex ? 2 : 1;

  int n_ = 0, stride_ = 0;
  // Of each part: U by rows (its diagonal apart), L by columns, both padded with zeros to the stride.
  std::vector<double> U_[kParts], L_[kParts], x_[kParts];
  std::vector<Scalar> pivot_inverse_;
  std::vector<int> row_;  // of A, that stands at each place
  struct Large;
  std::unique_ptr<Large> large_;
};

extern template class SmallLu<double>;
extern template class SmallLu<std::complex<double>>;

}  // namespace flexura::mbs
