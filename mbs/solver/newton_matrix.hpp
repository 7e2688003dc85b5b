// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "mbs/model/equations.hpp"
#include "mbs/solver/kinematic_blocks.hpp"
#include "mbs/solver/tangents.hpp"

/// The Newton matrix dF/dy + cj dF/dy' of the stabilised index-2 form (stabilised_index2.hpp), for the real
/// and the complex cj of an implicit Runge-Kutta method, several from derivatives taken once.
///
/// p is eliminated through the block-diagonal E = (cj I - d(Tv)/dp)^-1,
///     dp = E (r_p + T dv + T S G^T dmu),
/// which leaves a system of n_v + n_dyn + n_alg + 2 n_lambda unknowns.  It is solved scaled by D = M_ii^-1/2
/// and by the lengths of the rows of G D, so that masses of 1e-9 and 1e9 meet on equal terms.
namespace flexura::mbs {

/// E = (c I - A)^-1, block by block, after KinematicBlocks::update() and invert() (which
/// gives T^+, whatever its argument).  Scalar is double
/// or std::complex<double>.
template <class Scalar>
class KinematicInverse {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  void compute(const KinematicBlocks& blocks, Scalar c);

  /// Z (m x n_v) = Z_p (m x n_p) E T.
  void multiply_ET(const Eigen::MatrixXd& Z_p, Matrix& Z) const;
  /// Z (m x n_v) = Z_v (m x n_v) T^+ E T, the derivative by v of what depends on p through Z_v = Z_p T alone.
  void multiply_TET(const Eigen::MatrixXd& Z_v, Matrix& Z) const;
  /// x (n_p) = E y (n_p); may not be the same vector.
  void apply_E(const Vector& y, Vector& x) const;
  /// x (n_p) += E T w (n_v).
  void add_ET(const Vector& w, Vector& x) const;
  /// w (n_v) = T^+ y (n_p).
  void apply_T_inverse(const Vector& y, Vector& w) const;

 private:
  struct Block {
    Matrix E, ET, TET;  ///< p x p, p x v, v x v: T^+ E T
  };
  const KinematicBlocks* blocks_ = nullptr;
  std::vector<Block> inverse_;
  int n_v_ = 0;
};

template <class Scalar>
class NewtonMatrix {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  NewtonMatrix(const Sizes& sizes, std::vector<bool> holonomic);
  ~NewtonMatrix();

  /// From the derivatives and T, A, T^+ at one state; S (n_v) as in the form.  False when it is not finite.
  bool factor(const Tangents& derivatives, const KinematicBlocks& kinematics, const Eigen::VectorXd& S,
              Scalar cj);

  /// x = matrix^-1 rhs, both in the order of y, with the derivatives it was made from.
  void solve(const Tangents& derivatives, const Vector& rhs, Vector& x);

 private:
  Sizes n_;
  std::vector<bool> holonomic_;
  KinematicInverse<Scalar> inverse_;
  Eigen::VectorXd row_scale_, column_scale_;
  Matrix z_v_, h_v_, g_v_, GS_, J_;
  Vector rhs_, y_p_, dp_, dp_0_, w_, z_;
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace flexura::mbs
