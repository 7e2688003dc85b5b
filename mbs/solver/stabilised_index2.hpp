// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mbs/model/equations.hpp"
#include "mbs/solver/kinematic_blocks.hpp"
#include "mbs/solver/tangents.hpp"

/// The stabilised index-2 form of C. W. Gear, B. Leimkuhler, G. K. Gupta, J. Comput. Appl. Math. 12-13 (1985)
/// 77-90:
///
///     p' = T(p) (v + S G^T mu)          S = diag(1 / M_ii), constant between restarts
///     0  = M v' - f + G^T lambda
///     0  = c' - f_c
///     0  = b
///     0  = G v + g_t
///     0  = g                            (mu_k = 0 for a row without a position level)
///
/// Its exact solution has mu = 0; numerically mu takes up the drift, so that positions and velocities both
/// stay on their constraints.  y = (p, v, c, a, lambda, mu).
///
/// Newton matrix.  With cj from the BDF formula, p is eliminated through the block-diagonal E = (cj I -
/// d(Tv)/dp)^-1,
///     dp = E (r_p + T dv + T S G^T dmu),
/// which leaves a system of n_v + n_dyn + n_alg + 2 n_lambda unknowns.  It is solved scaled by D = M_ii^-1/2
/// and by the lengths of the rows of G D, so that masses of 1e-9 and 1e9 meet on equal terms.  Where it is
/// large and mostly zeros (many bodies on short chains, many loops) it is factorised by KLU (T. A. Davis, E.
/// Palamadai Natarajan, ACM TOMS 37 (2010) 36), else densely.
namespace flexura::mbs {

class StabilisedIndex2 {
 public:
  StabilisedIndex2(const Equations& eq, const State& start);
  ~StabilisedIndex2();

  int size() const { return n_y_; }
  int n_lambda() const { return n_.n_lambda; }
  /// Offsets of v, c, a, lambda, mu in y.
  int at_v() const { return n_.n_p; }
  int at_c() const { return n_.n_p + n_.n_v; }
  int at_a() const { return at_c() + n_.n_dyn; }
  int at_lambda() const { return at_a() + n_.n_alg; }
  int at_mu() const { return at_lambda() + n_.n_lambda; }

  /// Fixes S at this state and the switches until the next call.
  void set_start(const State& s);
  const Eigen::VectorXd& S() const { return S_; }  ///< n_v, its diagonal

  void pack(const State& s, const Eigen::VectorXd& v_dot, VectorRef y, VectorRef yp);
  void unpack(double t, ConstVectorRef y, State& s) const;

  /// False when an entry is not finite; the sentence about it is then non_finite().
  bool residual(double t, ConstVectorRef y, ConstVectorRef yp, VectorRef out);
  const std::string& non_finite() const { return non_finite_; }

  /// Builds and factorises dF/dy + cj dF/dy'.  False when it is not finite.
  bool factor(double t, double cj, ConstVectorRef y, ConstVectorRef yp, TangentScope scope);
  /// Forces may have come or gone: the next factor() looks for its zeros anew.
  void forget_structure();
  bool is_sparse() const;
  bool has_elastic_coordinates() const { return tangents_.has_elastic_coordinates(); }
  void solve(ConstVectorRef rhs, VectorRef x);

  long evaluations() const { return evaluations_ + tangents_.evaluations; }

 private:
  const Equations& eq_;
  Sizes n_;
  int n_y_;
  std::unique_ptr<Equations::Scratch> scratch_;
  State s_;
  KinematicBlocks kinematics_;
  Tangents tangents_;
  Eigen::VectorXd S_, w_, v_dot_, z_, row_scale_, column_scale_, rhs_, solution_, dp_, dp_0_, g_w_;
  Eigen::MatrixXd z_v_, h_v_, g_v_, GS_, J_;
  std::vector<bool> holonomic_;
  std::string non_finite_;
  long evaluations_ = 0;
  double cj_ = 0.0;
  void assemble_dense();
  void assemble_sparse();
  void scale(double cj);

  struct Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace flexura::mbs
