// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <complex>

#include "mbs/solver/algebra/history.hpp"
#include "mbs/solver/integrators/newton_matrix.hpp"
#include "mbs/solver/integrators/radau/radau_tableau.hpp"

namespace flexura::mbs {

/// The stabilised index-2 form F(t, y, y') with its Newton matrices dF/dy + cj dF/dy' for the real and the
/// complex cj of a step of Radau IIA (radau.hpp), from derivatives taken once: which derivatives, for which
/// step, and for how long they serve.
class RadauMatrices {
 public:
  RadauMatrices(const Equations& eq, const RadauTableau& tableau, const State& start);
  RadauMatrices(const RadauMatrices&) = delete;
  RadauMatrices& operator=(const RadauMatrices&) = delete;

  StabilisedIndex2& form() { return form_; }

  /// Nothing is left of what was taken before: after a restart.
  void forget();

  bool has_tangents() const { return has_tangents_; }
  /// The derivatives were taken for the step that begins at t.
  bool are_fresh(double t) const { return has_tangents_ && t_step_ == t; }
  /// They hold all there is, not the stiffness alone.
  bool are_full() const { return has_tangents_ && !is_cheap_; }
  /// They were taken ahead of where the step begins.
  bool look_ahead() const { return t_tangents_ > t_step_; }

  /// Takes the derivatives at (t, y, y') for the step that begins at t_step.  Of elastic coordinates they
  /// hold the stiffness alone, which is cheap, until Newton's method fails with that.
  void linearise(double t_step, double t, const Eigen::VectorXd& y, const Eigen::VectorXd& yp);
  /// Factors for a step h, where they are not there already; false when a matrix is not finite.
  bool factor(double h);
  /// Newton's method failed with fresh derivatives.  True when fuller ones may help.
  bool ask_for_more();
  /// A step went well.
  void count_accepted_step();

  /// x = (dF/dy + cj dF/dy')^-1 rhs, both of the size of y, for the real or the complex cj.
  void solve(const Eigen::VectorXd& rhs, Eigen::VectorXd& x) { real_.solve(rhs, x); }
  void solve(const Eigen::VectorXcd& rhs, Eigen::VectorXcd& x) { complex_.solve(rhs, x); }
  /// Of the residuals R_i of the stages the corrections dZ_i, in their place.
  void solve(std::array<Eigen::VectorXd, 3>& R);
  /// out = dF/dy' x.
  void multiply_rates(const Eigen::VectorXd& x, Eigen::VectorXd& out) const { form_.multiply_rates(x, out); }

  long linearised() const { return linearised_; }  ///< how often

  void remember(History& history);

 private:
  const RadauTableau& k_;
  StabilisedIndex2 form_;
  NewtonMatrix<double> real_;
  NewtonMatrix<std::complex<double>> complex_;
  bool has_tangents_ = false;
  double t_tangents_ = 0.0, t_step_ = 0.0;
  Eigen::VectorXd y_tangents_, yp_tangents_;
  bool is_cheap_ = false;  // with TangentScope::newton
  double h_ = 0.0;         // of the factors; 0: none
  // Full matrices to come, and how many the next failure asks for: few where it was a force that changed.
  int full_left_ = 0, full_span_ = 1, cheap_steps_ = 0;
  long linearised_ = 0;
  Eigen::VectorXd rhs_, x_;
  Eigen::VectorXcd rhs_c_, x_c_;
};

}  // namespace flexura::mbs
