// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/LU>
#include <memory>

#include "mbs/solver/algebra/history.hpp"
#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/algebra/tangents.hpp"

namespace flexura::mbs {

/// The constants of the generalised-alpha method (generalised_alpha.hpp) for a spectral radius rho at
/// infinite frequency, and of its local errors.
struct AlphaCoefficients {
  explicit AlphaCoefficients(double rho);

  double alpha_m, alpha_f, delta, gamma, beta, kappa;
  double error_p, error_v;  ///< of h^3 times the second derivative of accelerations

  double by_v(double h) const { return h * gamma * kappa; }     ///< d v / d v' in a step h
  double by_d(double h) const { return h * h * beta * kappa; }  ///< d d / d v', d the step's displacement
};

/// The Newton matrix of a step of generalised-alpha: the residuals of v', c', the algebraic equations and the
/// constraints, the latter divided by by_d (holonomic) or by_v, by v', c', a and lambda.
class AlphaMatrix {
 public:
  AlphaMatrix(const Equations& eq, const AlphaCoefficients& coefficients);

  /// Step it was made for; 0: there is none.
  double h() const { return h_; }
  void forget() { h_ = 0.0; }

  /// From derivatives at the state s with accelerations v_dot (n_v).
  void factor(double h, const State& s, const Eigen::VectorXd& v_dot);
  /// x = matrix^-1 F, both n_v + n_dyn + n_alg + n_lambda; F is used up.
  void solve(Eigen::VectorXd& F, Eigen::VectorXd& x);
  /// e <- the part of the velocities' error e (n_v) that the motion takes up: M e through the matrix.  What a
  /// change of step leaves in the accelerations along the constraints (of order h, with alternating sign) and
  /// in vibrations that the step does not resolve dies out by itself and must not steer the step.
  void filter(Eigen::VectorXd& e);

  long factored() const { return factored_; }                 ///< how often
  long evaluations() const { return tangents_.evaluations; }  ///< of the equations, for derivatives

  void remember(History& history);

 private:
  const Equations& eq_;
  const Sizes n_;
  const AlphaCoefficients& k_;
  Tangents tangents_;
  std::unique_ptr<KinematicBlocks> kinematics_;
  Eigen::VectorXd F_, x_, row_scale_, column_scale_;
  Eigen::MatrixXd J_, Z_q_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  State at_;  // what it was made from
  Eigen::VectorXd v_dot_;
  double h_ = 0.0;
  long factored_ = 0;
};

}  // namespace flexura::mbs
