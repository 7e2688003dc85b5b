// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

#include "mbs/solver/algebra/kinematic_inverse.hpp"
#include "mbs/solver/integrators/stabilised_index2.hpp"

/// The Newton matrix dF/dy + cj dF/dy' of the stabilised index-2 form (stabilised_index2.hpp): for the real
/// cj of a BDF formula, and for the real and the complex cj of an implicit Runge-Kutta method from
/// derivatives taken once.
///
/// p is eliminated through the block-diagonal E = (cj I - d(Tv)/dp)^-1,
///     dp = E (r_p + T dv + T S G^T dmu),
/// which leaves a system of n_v + n_dyn + n_alg + 2 n_lambda unknowns.  It is solved scaled by D = M_ii^-1/2
/// and by the lengths of the rows of G D, so that masses of 1e-9 and 1e9 meet on equal terms.  Where it is
/// large and mostly zeros (many bodies on short chains, many loops) it is factorised by KLU (T. A. Davis, E.
/// Palamadai Natarajan, ACM TOMS 37 (2010) 36), else densely.
namespace flexura::mbs {

/// Scalar is double or std::complex<double>.
template <class Scalar>
class NewtonMatrix {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// `form` outlives it.
  explicit NewtonMatrix(const StabilisedIndex2& form);
  ~NewtonMatrix();

  /// From the derivatives that the form took last.  False when it is not finite, or singular to KLU.
  bool factor(Scalar cj);

  /// x = matrix^-1 rhs, both in the order of y and of its size, with the derivatives it was made from.
  void solve(const Eigen::Ref<const Vector>& rhs, Eigen::Ref<Vector> x);

 private:
  struct Factors;

  void scale(double size);
  void assemble_dense(Scalar cj);
  void assemble_sparse(Scalar cj);
  bool factor_dense();
  bool factor_sparse();

  const StabilisedIndex2& form_;
  const Sizes n_;
  const int n_z_;  ///< n_v + n_dyn + n_alg
  KinematicInverse<Scalar> inverse_;
  Eigen::VectorXd row_scale_, column_scale_, length_;  ///< length_ of the rows of G D
  Matrix z_v_, h_v_, g_v_, GS_;                        ///< derivatives by v of what depends on p; S G^T
  Vector rhs_, solution_, y_p_, dp_, dp_0_, w_, z_, g_w_;
  std::unique_ptr<Factors> factors_;
};

}  // namespace flexura::mbs
