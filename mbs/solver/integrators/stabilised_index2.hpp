// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/algebra/tangents.hpp"

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
/// Its Newton matrices dF/dy + cj dF/dy' are made from the derivatives taken here: see newton_matrix.hpp.
namespace flexura::mbs {

struct SparseTangents;

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

  /// Fixes S at this state, the switches and which rows have a position level until the next call.
  void set_start(const State& s);
  const Eigen::VectorXd& S() const { return S_; }  ///< n_v, its diagonal

  void pack(const State& s, const Eigen::VectorXd& v_dot, VectorRef y, VectorRef yp);
  void unpack(double t, ConstVectorRef y, State& s) const;

  /// False when an entry is not finite; the sentence about it is then non_finite().
  bool residual(double t, ConstVectorRef y, ConstVectorRef yp, VectorRef out);
  const std::string& non_finite() const { return non_finite_; }

  /// Takes the derivatives at (t, y, y'), of which tangents() and kinematics() then hold the parts.
  void linearise(double t, ConstVectorRef y, ConstVectorRef yp, TangentScope scope);
  /// Behind linearise(): kinematics() for changes of p that are carried along with the motion (KinematicBlocks).
  void carry_along();
  const Sizes& sizes() const { return n_; }
  const Tangents& tangents() const { return tangents_; }
  /// The same without their zeros, made at the first call after linearise().
  const SparseTangents& sparse_tangents() const;
  /// out = M x with the mass matrix of the last linearise().
  void multiply_M(ConstVectorRef x, VectorRef out) const;
  /// out = dF/dy' x there.
  void multiply_rates(const Eigen::VectorXd& x, Eigen::VectorXd& out) const;
  const KinematicBlocks& kinematics() const { return kinematics_; }
  bool is_holonomic(int row) const { return holonomic_[row]; }
  bool has_elastic_coordinates() const { return tangents_.has_elastic_coordinates(); }
  /// Forces may have come or gone, and with them entries of the matrices; structure() counts these times.
  void forget_structure();
  long structure() const { return structure_; }

  long evaluations() const { return evaluations_ + tangents_.evaluations; }

 private:
  const Equations& eq_;
  Sizes n_;
  int n_y_;
  std::unique_ptr<Equations::Scratch> scratch_;
  State s_;
  KinematicBlocks kinematics_;
  Tangents tangents_;
  mutable std::unique_ptr<SparseTangents> sparse_;  // of tangents_, once anyone asked
  Eigen::VectorXd S_, w_, v_dot_, z_, p_dot_;
  std::vector<bool> holonomic_;
  std::string non_finite_;
  long evaluations_ = 0, structure_ = 0;
};

}  // namespace flexura::mbs
