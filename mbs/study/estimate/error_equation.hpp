// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <memory>
#include <vector>

#include "mbs/solver/integrators/newton_matrix.hpp"
#include "mbs/solver/integrators/radau/radau_tableau.hpp"
#include "mbs/solver/run/energy.hpp"

/// How far a run is from the exact motion, followed along its steps, whatever the integrator.
///
/// Between the ends of its steps a run is taken to be the polynomial w(t) of degree five that has its positions, velocities
/// and accelerations there: the exact solution of equations that have its defect d = F(t, w, w') on their right.  To first
/// order the error e = w - y_exact obeys
///
///     dF/dy e + dF/dy' e' = d(t)
///
/// (F the stabilised index-2 form, stabilised_index2.hpp; P. E. Zadunaisky, Numer. Math. 27 (1976) 21-39; J. Lang, J. G.
/// Verwer, Appl. Numer. Math. 57 (2007) 1-15).  Of d only integrals R from the begin of a step are wanted, of the momentum
///
///     R_v = int (M w'' - f + G^T lambda) dt,      and of dynamic states      R_c = c - c(0) - int f_c dt,
///
/// by Lobatto's four points, where the equations are evaluated; at the ends of a step they are met as far as Newton's
/// method has met them.  What w
/// itself lacks of the motion between the ends, of order six, drops out of these integrals, as it would not of those of
/// the integrator's own polynomial.  One step of Radau IIA, of order five, for one or several steps of the run then
/// carries e on, with derivatives that serve as long as they change little.
namespace flexura::study {

class ErrorEquation {
 public:
  /// `eq` outlives it; of a run of that duration [s].
  ErrorEquation(const mbs::Equations& eq, const mbs::State& start, double duration);

  /// The integrator starts there (the error stays what it is), and so many of its steps are one of this equation.
  void restart(const mbs::State& s, const Eigen::VectorXd& v_dot, int steps_at_once);
  /// The integrator's next step: its begin, and the rest of Lobatto's points.
  void step(const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes);
  /// Solves for what steps are waiting.
  void close();

  /// Until then the error is known; steps behind it are waiting [s].
  double known_until() const { return t_end_; }
  /// w - y_exact at t within the last step of this equation: of p (n_p), v (n_v) and c (n_dyn), behind one another.
  void at(double t, Eigen::VectorXd& e) const;
  /// y - w of a state within the step entered last (of c: 0), likewise.
  void beside(const mbs::State& s, Eigen::VectorXd& out);

  bool is_lost() const { return is_lost_; }        ///< it left all numbers
  long linearised() const { return linearised_; }  ///< how often

 private:
  // Derivatives serve while stiffness and damping, as far as they count within the run, and masses change by less than
  // this part of themselves.
  static constexpr double kSmallChange = 0.1;
  static constexpr int kLongestSpan = 16;

  // The polynomial w of a step.
  struct Path {
    double t = 0.0, h = 0.0;
    std::array<Eigen::VectorXd, 6> p;  // p, h p', h^2 p'' at its begin and at its end
  };

  void linearise();
  double change() const;
  void rates(const mbs::State& s, const Eigen::VectorXd& v_dot, double h, Eigen::VectorXd* p);
  void follow(double x, mbs::State& s, Eigen::VectorXd& v_dot);
  void follow_norms(const mbs::State& s, Eigen::VectorXd& v_dot);
  void defects(const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes);
  void add(const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes);
  void solve(double h, const std::array<Eigen::VectorXd, 3>& R);

  const mbs::Equations& eq_;
  mbs::Sizes n_;
  mbs::RadauTableau k_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  mbs::StabilisedIndex2 form_;
  mbs::NewtonMatrix<double> real_;
  mbs::NewtonMatrix<std::complex<double>> complex_;
  Eigen::Index n_rates_;  // p, v, c
  double duration_;

  // What steps are solved with.
  bool is_stale_ = true;
  int span_ = 1, left_ = 0;
  double h_factors_ = 0.0;
  long linearised_ = 0;
  Eigen::MatrixXd M_, D_, K_, K_now_;

  // Of the step entered last: its path, and what the equations say at Lobatto's points.
  mbs::KinematicBlocks kinematics_;
  bool has_turns_ = false;  // coordinates whose rates are no velocities
  Path path_;
  std::array<Eigen::VectorXd, 4> r_;
  std::array<Eigen::VectorXd, 4> c_rate_;
  mbs::State inner_;
  mbs::Instant middle_;  // of the steps that wait
  Eigen::VectorXd inner_v_dot_, v_dot_end_, c_rate_end_, r_end_, b_, p_, p_up_, p_down_, p_rate_, p_rate2_,
      v_step_, y_, yp_;
  bool has_end_ = false;

  // Steps that wait: how many, R at the end of the last, and its integrals int R dt, int (t - t_begin) R dt.
  int steps_at_once_ = 1, waiting_ = 0;
  Eigen::VectorXd R_, R_sum_, R_moment_;

  // The last step of this equation.
  double t_begin_ = 0.0, t_end_ = 0.0, t_waiting_ = 0.0;
  Eigen::VectorXd e_begin_, e_end_;
  std::array<Eigen::VectorXd, 3> e_;
  bool is_lost_ = false;
  Eigen::VectorXd rhs_, x_, rates_;
  Eigen::VectorXcd rhs_c_, x_c_;
};

}  // namespace flexura::study
