// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/algebra/saddle.hpp"

/// Consistent accelerations, multipliers, algebraic states and rates at given p, v, c, t (index 1):
///
///     0 = b(p, v, c, a, t)
///     [ M  G^T ] [ v_dot  ]   [    f   ]
///     [ G   0  ] [ lambda ] = [ -gamma ],     c_dot = f_c
///
/// Where b holds v_dot or lambda (forces that read reactions) a is sought by Newton's method on b(v_dot(a), lambda(a), a).
///
/// Without constraints M^-1 comes from the equations in O(n) (Equations::solve_mass) where they offer it.
namespace flexura::mbs {

/// A state of the right sizes with everything zero.
State make_state(const Equations& eq);

class AccelerationSolver {
 public:
  explicit AccelerationSolver(const Equations& eq);
  ~AccelerationSolver();

  /// Fills s.lambda, s.a and v_dot (n_v); s.a is the start of its own Newton iteration.  Forces may depend on
  /// s.lambda (friction in joints): the linear system is then iterated.  Throws std::runtime_error, one
  /// sentence, where M is singular, b = 0 has no solution near s.a or a force is not finite.
  void solve(State& s, Eigen::VectorXd& v_dot);

  /// The same from values nearby (those of an integrator's polynomial), with factors of M and G that were made
  /// at a state nearby: each pass takes away what the last one missed, until no more than `enough` is left or
  /// the gain is small.  Returns what may be left, relative to v_dot and s.lambda; with old factors more than
  /// `enough` means that they are too old.
  double refine(SaddleSolver& factors, State& s, Eigen::VectorXd& v_dot, double enough);
  static constexpr double at_round_off = 1e-11;
  /// Without constraints, by M^-1 in O(n); false where the equations do not offer it.
  bool solve_recursively(State& s, Eigen::VectorXd& v_dot);
  /// Of equations that do not wait for accelerations (Equations::algebraic_is_coupled()).
  void solve_algebraic(State& s);

  const Eigen::VectorXd& c_rate() const { return c_rate_; }                      ///< f_c of the last solve
  int constraint_rank() const { return n_.n_lambda == 0 ? 0 : saddle_.rank(); }  ///< of G in the last solve

 private:
  double improve(SaddleSolver& factors, State& s, Eigen::VectorXd& v_dot);
  void solve_linear(SaddleSolver& factors, State& s, Eigen::VectorXd& v_dot);
  void solve_coupled(SaddleSolver& factors, State& s, Eigen::VectorXd& v_dot);

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  std::unique_ptr<Equations::Scratch> mass_scratch_;  // keeps the factors of M while momentum() is evaluated
  SaddleSolver saddle_;
  Eigen::MatrixXd M_, G_;
  Eigen::VectorXd r_, c_rate_, b_, g_ddot_, dv_, dlambda_;
  // Of the algebraic equations.
  Eigen::VectorXd v_dot_trial_, b_now_;
  struct Factor;
  std::unique_ptr<Factor> lu_;
  State trial_;
  Eigen::MatrixXd J_;
  Eigen::VectorXd rest_, b_step_, step_;
};

}  // namespace flexura::mbs
