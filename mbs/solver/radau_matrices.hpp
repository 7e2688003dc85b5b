// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>

#include "mbs/solver/newton_matrix.hpp"

namespace flexura::mbs {

/// The stabilised index-2 form F(t, y, y') with its Newton matrices dF/dy + cj dF/dy' for the real and the
/// complex cj of a step of Radau IIA (radau.hpp), from derivatives taken once.
class RadauMatrices {
 public:
  RadauMatrices(const Equations& eq, const State& start) : form_(eq, start), real_(form_), complex_(form_) {}
  RadauMatrices(const RadauMatrices&) = delete;
  RadauMatrices& operator=(const RadauMatrices&) = delete;

  StabilisedIndex2& form() { return form_; }

  /// From the derivatives that the form took last; false when a matrix is not finite.
  bool factor(double real, std::complex<double> complex) {
    return real_.factor(real) && complex_.factor(complex);
  }
  /// x = (dF/dy + cj dF/dy')^-1 rhs, both of the size of y, for the real or the complex cj.
  void solve(const Eigen::VectorXd& rhs, Eigen::VectorXd& x) { real_.solve(rhs, x); }
  void solve(const Eigen::VectorXcd& rhs, Eigen::VectorXcd& x) { complex_.solve(rhs, x); }
  /// out = dF/dy' x.
  void multiply_rates(const Eigen::VectorXd& x, Eigen::VectorXd& out) const {
    const int at_v = form_.at_v(), n_v = form_.sizes().n_v;
    out = x;
    out.segment(at_v, n_v).noalias() = form_.tangents().M * x.segment(at_v, n_v);
    out.tail(form_.size() - form_.at_a()).setZero();
  }

 private:
  StabilisedIndex2 form_;
  NewtonMatrix<double> real_;
  NewtonMatrix<std::complex<double>> complex_;
};

}  // namespace flexura::mbs
